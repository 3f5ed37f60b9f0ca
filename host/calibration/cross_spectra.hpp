#pragma once

#include <complex>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/fft.hpp"

namespace roadbalance {

/// Spectra of all pairs of some channels by Welch's method (Hann, half overlapped), for a band of bins.
class CrossSpectra {
 public:
  struct Settings {
    int channels;
    double rate_hz;
    double segment_s = 2.0;
    double low_hz, high_hz;  ///< bins within
  };
  /// @throws std::invalid_argument if no bin lies within the band
  explicit CrossSpectra(const Settings& settings);

  /// The next sample of all channels.
  void add(std::span<const double> sample);
  /// A hole is not a signal: what was averaged is kept, the segment it cuts is dropped.
  void interrupt() { filled_ = 0; }

  int averages() const { return averages_; }
  /// Of independent segments that would scatter as much: neighbours that overlap by half share a little.
  double independent_averages() const { return averages_ / kOverlapCost; }
  std::size_t bins() const { return sum_.size(); }
  double frequency_hz(std::size_t bin) const { return static_cast<double>(first_bin_ + bin) * step_hz_; }
  /// [channel x channel] sum of conj(X_row) X_column, up to a scale: the phase of (a, b) is b's over a's.
  const Eigen::MatrixXcd& matrix(std::size_t bin) const { return sum_[bin]; }

 private:
  /// 1 + 2 c^2, c = 1/6 the correlation of Hann windows that overlap by half; of a segment's power.
  static constexpr double kOverlapCost = 1.0 + 2.0 / 36.0;
  void add_segment();

  RealFft fft_;
  double step_hz_;
  std::size_t first_bin_ = 0;
  std::vector<double> window_, tapered_;
  std::vector<std::complex<double>> lines_;
  Eigen::MatrixXd history_;  ///< [sample x channel]
  Eigen::Index filled_ = 0;
  Eigen::MatrixXcd at_bins_;           ///< [channel x bin] of a segment
  std::vector<Eigen::MatrixXcd> sum_;  ///< [bin]
  int averages_ = 0;
};

}  // namespace roadbalance
