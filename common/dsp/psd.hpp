#pragma once

#include <span>
#include <vector>

#include "common/dsp/fft.hpp"
#include "common/dsp/window.hpp"

namespace roadbalance {

/// One-sided power spectral density of a signal by Welch's method: windowed, overlapping segments, averaged
/// linearly.  With x in m/s^2 the density is in (m/s^2)^2 / Hz:
///
///     S[k] = c / (rate sum(w^2)) * mean over segments of |DFT(w x)[k]|^2,   c = 2, but 1 at 0 Hz and rate /
///     2
///
/// so its integral is the mean square.  A sine of amplitude A on bin k has S[k] enbw_hz() = A^2 / 2.  A mean
/// value stays in: it shows in the first bins, as many as the window is wide.
///
/// Source: P. D. Welch, IEEE Trans. Audio Electroacoustics AU-15 (1967) 70-73.
class WelchPsd {
 public:
  struct Settings {
    double rate_hz;
    int segment;           ///< samples, >= 2
    double overlap = 0.5;  ///< of the segment, 0 <= overlap < 1
    Window window = Window::kHann;
  };

  /// @throws std::invalid_argument
  explicit WelchPsd(const Settings& settings);

  /// Takes any number of further samples of the signal, without a hole; never allocates.
  void add(std::span<const double> samples);

  /// Forgets everything, as after a hole in the signal.
  void reset();

  int averages() const { return averages_; }
  int bins() const { return fft_.bins(); }
  double step_hz() const { return step_hz_; }
  double enbw_hz() const { return enbw_hz_; }

  /// [bins] density at 0, step_hz(), 2 step_hz() ...; zero before the first segment is full.
  std::vector<double> density() const;

 private:
  void add_segment(const double* segment);

  RealFft fft_;
  std::vector<double> window_;
  std::size_t hop_;
  double step_hz_;
  double enbw_hz_;
  double scale_;
  std::vector<double> history_;  ///< the segment that is being filled
  std::size_t filled_ = 0;
  std::vector<BinLane> lines_;  ///< of one segment
  std::vector<double> sum_;     ///< [bin], to the end of a lane
  int averages_ = 0;
};

}  // namespace roadbalance
