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

/// Limit of the instants of a file, from its zero, so that they fit into nanoseconds and into a block: 63
/// years, which has room for Unix times until 2033.
inline constexpr double kFarthest_s = 2e9;
inline constexpr const char* kTooFarOff = "is too far off; allowed: -2e9 to 2e9 s";
inline bool is_countable(double time_s) {
  return std::abs(time_s) <= kFarthest_s;
}

/// Samples of some instants, one after the other.
struct SampleRows {
  std::size_t channels = 0;
  std::vector<double> time_s = {};  ///< [row], within the limit and never falling
  std::vector<double> value =
      {};  ///< [row * channels + channel] in the channel's unit; NaN: there is no sample

  std::size_t rows() const { return time_s.size(); }
  std::span<const double> row(std::size_t k) const {
    return std::span(value).subspan(k * channels, channels);
  }
  void clear() {
    time_s.clear();
    value.clear();
  }
};

/// A channel as a file describes it.
struct FileChannel {
  std::string name = {};
  std::string unit = {};  ///< as it stands there; empty: there is none
  std::string node = {};  ///< that it comes from; empty: the file has none
  /// Without a unit: the SI unit of the quantity that the file says it is; empty: the file says none.
  std::string quantity = {};
  bool operator==(const FileChannel&) const = default;
};

/// A file of samples from another program, before vehicle.toml gives each channel its place.  It can be read
/// any number of times and is never held: memory does not grow with its length.
class SampleSource {
 public:
  virtual ~SampleSource() = default;

  /// The time column is none of them.
  virtual const std::vector<FileChannel>& channels() const = 0;
  /// Replaces the rows in `rows` by the next ones.  False: there are no more, and `rows` is empty.
  /// @throws as documented where the source is opened
  virtual bool read(SampleRows& rows) = 0;
  /// Goes back to the first row.
  virtual void rewind() = 0;
  /// The share of the file that has been read since its first row, 0 to 1.
  virtual double part() const = 0;

  /// Rows that one read() gives at most.
  static constexpr std::size_t kRowsAtOnce = 1024;
};

using OpenSamples = std::function<std::unique_ptr<SampleSource>(const std::filesystem::path& file)>;

}  // namespace roadbalance
