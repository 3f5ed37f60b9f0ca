#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace roadbalance {

/// No instant of a file lies further from its zero, so that nanoseconds of it can be counted and a block of
/// it be read again: 63 years, in which Unix times have room until 2033.
inline constexpr double kFarthest_s = 2e9;
inline constexpr const char* kTooFarOff = "is too far off; allowed: -2e9 to 2e9 s";
inline bool is_countable(double time_s) {
  return std::abs(time_s) <= kFarthest_s;
}

/// Samples of some instants, one after the other.
struct SampleRows {
  std::size_t channels = 0;
  std::vector<double> time_s = {};    ///< [row], countable and never falling
  std::vector<double> value_si = {};  ///< [row * channels + channel]; NaN: there is no sample

  std::size_t rows() const { return time_s.size(); }
  std::span<const double> row(std::size_t k) const {
    return std::span(value_si).subspan(k * channels, channels);
  }
  void clear() {
    time_s.clear();
    value_si.clear();
  }
};

/// A file of samples that somebody else took, before vehicle.toml gives each channel its place.  It is gone
/// through as often as one likes and never held: memory does not grow with its length.
class SampleSource {
 public:
  virtual ~SampleSource() = default;

  /// Of each channel; the time column is not one.
  virtual const std::vector<std::string>& names() const = 0;
  /// The next rows in place of those in `rows`.  False: there are no more, and none is in `rows`.
  /// @throws as whoever opened it says
  virtual bool read(SampleRows& rows) = 0;
  /// The first row is the next one again.
  virtual void rewind() = 0;
  /// How much of the file has been gone through since its first row, 0 to 1.
  virtual double part() const = 0;

  /// Rows that one read() gives at most.
  static constexpr std::size_t kRowsAtOnce = 1024;
};

using OpenSamples = std::function<std::unique_ptr<SampleSource>(const std::filesystem::path& file)>;

}  // namespace roadbalance
