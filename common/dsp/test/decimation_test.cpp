#include "common/dsp/decimation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace roadbalance {
namespace {

/// Gain at `frequency`, in units of the new rate.
double gain(const Eigen::VectorXd& taps, int factor, double frequency) {
  const Eigen::Index centre = (taps.size() - 1) / 2;
  double sum = 0.0;
  for (Eigen::Index k = 0; k < taps.size(); ++k)
    sum += taps(k) * std::cos(2.0 * std::numbers::pi * frequency / factor * static_cast<double>(k - centre));
  return sum;
}

TEST(DecimationTaps, PassWhatTheNewRateCarriesAndStopWhatWouldFoldOnIt) {
  for (const int factor : {2, 3, 7, 16}) {
    const Eigen::VectorXd taps = decimation_taps(factor);
    ASSERT_EQ(taps.size(), 16 * factor + 1);
    EXPECT_NEAR(taps.sum(), 1.0, 1e-14);
    for (double f = 0.0; f <= kDecimationFlatTo; f += 0.005)
      EXPECT_NEAR(gain(taps, factor, f), 1.0, 2e-4) << f;
    for (double f = kDecimationStopsFrom; f <= 0.5 * factor; f += 0.005)
      EXPECT_LT(std::abs(gain(taps, factor, f)), 2e-4) << f;
  }
}

TEST(ReductionTaps, KeepFourFifthsAndLetNothingFold) {
  for (const int factor : {2, 3, 5, 16}) {
    const Eigen::VectorXd taps = reduction_taps(factor);
    ASSERT_EQ(taps.size(), 2 * kReductionHalf * factor + 1);
    EXPECT_NEAR(taps.sum(), 1.0, 1e-14);
    EXPECT_EQ(taps, taps.reverse()) << "linear phase";
    for (double f = 0.0; f <= kReductionFlatTo; f += 0.001)
      EXPECT_NEAR(gain(taps, factor, f), 1.0, kReductionRipple) << f;
    for (double f = 0.5; f <= 0.5 * factor; f += 0.001)
      EXPECT_LT(std::abs(gain(taps, factor, f)), kReductionRipple) << f;
  }
  EXPECT_EQ(reduction_taps(1), Eigen::VectorXd::Ones(1));
}

TEST(DecimationTaps, DoNothingWhereNothingIsLeftOut) {
  EXPECT_EQ(decimation_taps(1), Eigen::VectorXd::Ones(1));
}

}  // namespace
}  // namespace roadbalance
