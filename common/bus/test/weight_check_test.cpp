#include "common/bus/weight_check.hpp"

#include <gtest/gtest.h>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {
namespace {

TEST(WeightCheck, ComesBackAsItWasSent) {
  WeightCheck sent{.wheel = 3,
                   .time_ns = 8,
                   .state = WeightCheckState::kKnown,
                   .verdict = WeightCheckVerdict::kLess,
                   .placement = WeightPlacement::kMirrored,
                   .fitted_known = true,
                   .weight_radius_m = 0.19,
                   .reduction = 0.75,
                   .sigma_reduction = 0.125,
                   .text = "drive1"};
  sent.before_g << 1.0, 2.0;
  sent.after_g << 3.0, 4.0;
  sent.fitted_g << 5.0, -6.0;
  sent.before_covariance_g2 << 4.0, 1.0, 1.0, 3.0;
  sent.after_covariance_g2 << 2.0, 0.5, 0.5, 1.0;
  const auto bytes = encode(sent);
  EXPECT_LT(bytes.size(), 1400U) << "one datagram";
  const auto got = decode_weight_check(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->wheel, 3);
  EXPECT_EQ(got->time_ns, 8);
  EXPECT_EQ(got->state, WeightCheckState::kKnown);
  EXPECT_EQ(got->verdict, WeightCheckVerdict::kLess);
  EXPECT_EQ(got->placement, WeightPlacement::kMirrored);
  EXPECT_TRUE(got->fitted_known);
  EXPECT_EQ(got->before_g, sent.before_g);
  EXPECT_EQ(got->after_g, sent.after_g);
  EXPECT_EQ(got->fitted_g, sent.fitted_g);
  EXPECT_EQ(got->before_covariance_g2, sent.before_covariance_g2);
  EXPECT_EQ(got->after_covariance_g2, sent.after_covariance_g2);
  EXPECT_EQ(got->weight_radius_m, 0.19);
  EXPECT_EQ(got->reduction, 0.75);
  EXPECT_EQ(got->sigma_reduction, 0.125);
  EXPECT_EQ(got->text, "drive1");
}

TEST(WeightCheck, RefusesWhatCannotBe) {
  const auto taken = [](auto spoil) {
    WeightCheck sent;
    spoil(sent);
    return decode_weight_check(encode(sent)).has_value();
  };
  EXPECT_TRUE(taken([](WeightCheck&) {}));
  for (const std::int32_t value : {-1, 6}) {
    EXPECT_FALSE(taken([&](auto& sent) { sent.wheel = value; })) << value;
    EXPECT_FALSE(taken([&](auto& sent) { sent.state = static_cast<WeightCheckState>(value); })) << value;
    EXPECT_FALSE(taken([&](auto& sent) { sent.verdict = static_cast<WeightCheckVerdict>(value); })) << value;
    EXPECT_FALSE(taken([&](auto& sent) { sent.placement = static_cast<WeightPlacement>(value); })) << value;
  }
}

}  // namespace
}  // namespace roadbalance
