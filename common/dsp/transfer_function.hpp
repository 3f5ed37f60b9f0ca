#pragma once

#include <complex>
#include <optional>
#include <span>
#include <vector>

namespace roadbalance {

/// How two signals go together, bin by bin, with what chance alone would do.
struct TransferFunction {
  std::vector<std::complex<double>> h1;  ///< G_xy / G_xx: noise on the output does not bias it
  std::vector<std::complex<double>> h2;  ///< G_yy / G_yx: noise on the input does not bias it
  /// Total least squares with each signal in units of its own rms, sqrt(G_yy / G_xx) e^{j arg G_xy}: noise on
  /// both alike.  |h1| <= |hv| <= |h2|.
  std::vector<std::complex<double>> hv;
  std::vector<double> coherence;        ///< gamma^2 = |G_xy|^2 / (G_xx G_yy), 0 .. 1
  std::vector<double> coherence_sigma;  ///< sqrt(2 / n) (1 - gamma^2) gamma
  /// Radius of the circle about h1 that holds the truth with 95 %; infinite for fewer than two averages:
  /// r^2 = F_{2, 2n-2; 0.95} / (n - 1) (1 - gamma^2) G_yy / G_xx.
  std::vector<double> radius_95;
  double coherence_by_chance =
      1.0;  ///< of unrelated signals in 95 % of the bins below it, 1 - 0.05^{1/(n-1)}
};

/// @param input, output         [bins] G_xx, G_yy
/// @param cross                 [bins] G_xy
/// @param independent_averages  n, as CrossSpectra reports
/// Bins where one of the signals is 0 have coherence 0 and H = 0.
///
/// Source: J. S. Bendat, A. G. Piersol, Random Data, 4th ed., 2010, sections 6.2 and 9.2; for Hv G. T.
/// Rocklin, J. Crowley, H. Vold, Proc. 3rd International Modal Analysis Conference (1985) 272-278.
/// @throws std::invalid_argument if the lengths differ
TransferFunction transfer_function(std::span<const double> input, std::span<const double> output,
                                   std::span<const std::complex<double>> cross, double independent_averages);

/// By how much the output is behind the input, s: the mean slope of the phase from bin to bin where coherence
/// is beyond chance, each weighed by gamma^2 / (1 - gamma^2), one over the variance of a phase.  Nothing: no
/// bin has such coherence.  Unambiguous within half a period of step_hz.
std::optional<double> mean_delay_s(const TransferFunction& h, double step_hz);

}  // namespace roadbalance
