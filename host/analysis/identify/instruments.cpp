#include "host/analysis/identify/instruments.hpp"

#include <numbers>

namespace roadbalance {

Instrument chassis_instrument() {
  constexpr double kCutoffHz = 15.0;
  return {butterworth(kInstrumentOrder, kCutoffHz), kCutoffHz, 0.020};
}

Instrument tyre_instrument() {
  constexpr double kLowHz = 1.0, kHighHz = 80.0;
  // 1 / ((p + wl/wh)^2 (p^3 + 2 p^2 + 2 p + 1)) with p = s / wh, in companion form scaled by wh.
  const double low = kLowHz / kHighHz;
  const Eigen::Vector3d high_pass(low * low, 2.0 * low, 1.0);
  const Eigen::Vector4d low_pass(1.0, 2.0, 2.0, 1.0);
  Eigen::VectorXd product = Eigen::VectorXd::Zero(kInstrumentOrder + 1);
  for (int i = 0; i < 3; ++i) product.segment<4>(i) += high_pass(i) * low_pass;
  ContinuousFilter filter = companion(product.head(kInstrumentOrder));
  filter.F *= 2.0 * std::numbers::pi * kHighHz;
  filter.G *= 2.0 * std::numbers::pi * kHighHz;
  return {filter, kHighHz, 0.004};
}

}  // namespace roadbalance
