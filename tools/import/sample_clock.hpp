#pragma once

#include <cstdint>
#include <vector>

namespace roadbalance {

/// The uniform clock behind uneven stamps: sample `index` was taken at first_s + index * period_s.
struct SampleClock {
  struct Hole {
    double after_s;        ///< stamp of the last sample before it
    std::int64_t samples;  ///< missing, by the clock
    std::int64_t row;      ///< of the first sample behind it
  };
  double first_s = 0.0;
  double period_s = 0.0;
  std::vector<Hole> hole;

  double time_s(std::int64_t index) const { return first_s + period_s * static_cast<double>(index); }
};

/// Index of each sample in turn; it jumps over the holes.
class SampleIndex {
 public:
  explicit SampleIndex(const SampleClock& clock) : hole_(clock.hole) {}
  std::int64_t next() {
    if (next_hole_ < hole_.size() && hole_[next_hole_].row == row_) missing_ += hole_[next_hole_++].samples;
    return row_++ + missing_;
  }

 private:
  const std::vector<SampleClock::Hole>& hole_;
  std::size_t next_hole_ = 0;
  std::int64_t row_ = 0, missing_ = 0;
};

/// Fits a line of time over sample index, one stamp after the other.  Stamps may be bunched as a serial port
/// delivers them; samples are missing only where the stamps jump by more than 1.5 s or 50 periods.
class SampleClockFit {
 public:
  /// @param nominal_hz  defines 50 periods; sums are of the stamps' deviations from it, so that
  ///                    hours of them lose no digit
  explicit SampleClockFit(double nominal_hz) : nominal_hz_(nominal_hz) {}

  /// @param stamp_s  not below the one before
  /// @throws std::invalid_argument if there are more holes than are worth an import
  void add(double stamp_s);
  std::int64_t rows() const { return rows_; }
  /// @throws std::invalid_argument if the stamps do not determine a line, or leave too large a hole
  SampleClock clock() const;

  static constexpr std::size_t kMostHoles = 100'000;

 private:
  /// Samples without a hole between them.
  struct Piece {
    std::int64_t begin = 0, samples = 0;
    double before_s = 0.0;      ///< stamp of the last sample before it
    double late_s = 0.0;        ///< mean of what the stamps are behind nominal ones, by row
    double late_product = 0.0;  ///< sum of (row - mean row) * (late - mean late)

    double mean_row() const;
    double square() const;  ///< sum of (row - mean row)^2
  };

  double nominal_hz_;
  double first_s_ = 0.0, last_s_ = 0.0;
  std::int64_t rows_ = 0;
  std::vector<Piece> piece_;
};

}  // namespace roadbalance
