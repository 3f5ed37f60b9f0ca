#include "host/analysis/identify/instruments.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace roadbalance {
namespace {

// (p + l)^2 (p^3 + 2 p^2 + 2 p + 1) multiplied out, l = 1 Hz / 80 Hz.
TEST(TyreInstrument, HasThePolesOfItsFormula) {
  constexpr double l = 1.0 / 80.0, kHigh_rad_s = 2.0 * std::numbers::pi * 80.0;
  const Instrument tyre = tyre_instrument();
  Eigen::RowVectorXd denominator(5);
  denominator << l * l, 2 * l + 2 * l * l, 1 + 4 * l + 2 * l * l, 2 + 4 * l + l * l, 2 + 2 * l;
  EXPECT_TRUE((tyre.filter.F.row(4) / kHigh_rad_s).isApprox(-denominator, 1e-14))
      << tyre.filter.F.row(4) / kHigh_rad_s;
  EXPECT_TRUE(tyre.filter.G.isApprox(kHigh_rad_s * Eigen::VectorXd::Unit(5, 4), 1e-14));
}

}  // namespace
}  // namespace roadbalance
