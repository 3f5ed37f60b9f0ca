#include "common/types/angle_sigma.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(AngleSigma, IsReadBackRoundedUpByHalfAnOctaveAtMost) {
  for (int line : {0, 1})
    for (double deg = 0.001; deg < 32.0; deg *= 1.07) {
      const auto read = angle_sigma_rad(with_angle_sigma(0, line, deg * kDegree), line);
      ASSERT_TRUE(read) << deg;
      EXPECT_GE(*read / kDegree, deg * (1.0 - 1e-8));
      EXPECT_LE(*read / kDegree, deg * std::sqrt(2.0) * (1.0 + 1e-8));
    }
}

TEST(AngleSigma, IsWrittenTheSameOnceItWasRead) {
  for (std::int32_t code = 1; code <= kMostAngleSigma; ++code) {
    const std::int32_t quality = code << angle_sigma_place(1);
    EXPECT_EQ(with_angle_sigma(0, 1, *angle_sigma_rad(quality, 1)), quality);
  }
}

TEST(AngleSigma, LeavesTheFlagsAndTheOtherLineAlone) {
  const std::int32_t flags = kQualityOverload | kQualityAfterGap;
  const std::int32_t one = with_angle_sigma(flags, 0, 0.1 * kDegree);
  EXPECT_EQ(one & kQualityFlags, flags);
  EXPECT_FALSE(angle_sigma_rad(one, 1));
  const std::int32_t both = with_angle_sigma(one, 1, 7.0 * kDegree);
  EXPECT_EQ(angle_sigma_rad(both, 0), angle_sigma_rad(one, 0));
  EXPECT_LT(both, 1 << 16) << "what every receiver takes";
  EXPECT_EQ(with_angle_sigma(both, 0, 0.3 * kDegree),
            with_angle_sigma(with_angle_sigma(flags, 1, 7.0 * kDegree), 0, 0.3 * kDegree));
}

TEST(AngleSigma, IsNotToldWhereItIsNotKnown) {
  for (const double none : {std::numeric_limits<double>::infinity(), std::nan(""), -1.0, 33.0 * kDegree})
    EXPECT_EQ(with_angle_sigma(kQualityAfterGap | 5 << angle_sigma_place(0), 0, none), kQualityAfterGap);
  EXPECT_EQ(angle_sigma_rad(with_angle_sigma(0, 0, 0.0), 0), kLeastAngleSigma_rad);
  EXPECT_FALSE(angle_sigma_rad(0, 0));
}

}  // namespace
}  // namespace roadbalance
