#include "host/analysis/identify/rotation.hpp"

#include <complex>

namespace roadbalance {

bool has_reference(const Eigen::Ref<const SignalMatrix>& signals, int wheel) {
  const auto power =
      signals.row(cosine_row(wheel)).array().square() + signals.row(sine_row(wheel)).array().square();
  return power.minCoeff() > 0.25;
}

std::optional<double> mean_rotation(const Eigen::Ref<const SignalMatrix>& signals, int wheel,
                                    double rate_hz) {
  if (!has_reference(signals, wheel)) return std::nullopt;
  double turned = 0.0;
  for (Eigen::Index k = 1; k < signals.cols(); ++k)
    turned += std::arg(reference(signals.col(k), wheel) * std::conj(reference(signals.col(k - 1), wheel)));
  return turned * rate_hz / static_cast<double>(signals.cols() - 1);
}

}  // namespace roadbalance
