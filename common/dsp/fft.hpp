#pragma once

#include <complex>
#include <memory>
#include <span>

#include "common/dsp/parted_lines.hpp"

namespace roadbalance {

/// Discrete Fourier transform of real signals of one length, planned once:
///
///     out[k] = sum over n of in[n] exp(-2 pi j k n / size),   k = 0 .. size / 2
///
/// FFTW behind it, or Eigen's transform where the project was built with RB_WITH_FFTW=OFF.  The same
/// input gives the same bits in every run.  One object serves one thread at a time; different objects any.
class RealFft {
 public:
  /// @param size  samples, >= 2
  /// @throws std::invalid_argument
  explicit RealFft(int size);
  RealFft(RealFft&&) noexcept;
  RealFft& operator=(RealFft&&) noexcept;
  ~RealFft();

  int size() const { return size_; }
  int bins() const { return size_ / 2 + 1; }

  /// @param in   [size] samples
  /// @param out  [bins] unscaled transform
  void forward(std::span<const double> in, std::span<std::complex<double>> out);

  /// The same without copies: [size] samples to be filled in, each time, ...
  std::span<double> input();
  /// ... and the [bins] transform of them, valid until the next.
  std::span<const std::complex<double>> transform();
  /// Transforms [size] samples that lie elsewhere, at the beginning of a line of the cache.
  std::span<const std::complex<double>> transform(std::span<const double> in);
  /// The same, real and imaginary parts of each eight bins apart.
  /// @param lanes  [2 ceil(bins / 8)]; bins that there are not are left as they are, or 0
  void transform(std::span<const double> in, std::span<BinLane> lanes);

 private:
  struct Plan;
  int size_;
  std::unique_ptr<Plan> plan_;
};

}  // namespace roadbalance
