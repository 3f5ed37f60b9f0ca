#include "host/analyser/waterfall_view.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/analysis/orders/test/synthetic_rotor.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
using std::numbers::pi;

const VehicleConfig& car() {
  static const VehicleConfig vehicle = test::rotor_vehicle(1.0, {2});
  return vehicle;
}

class WaterfallViewTest : public testing::Test {
 protected:
  void look() { shown_.take({.viewer = 1, .waterfall = {{2, {3, 0}}}}, begin_); }
  /// Once a turn of the left wheel, 1.5 m/s^2, at 12 turns a second.
  void drive() {
    const auto left = [](double t) { return 2 * pi * 12.0 * t + 0.3; };
    const test::SyntheticDrive drive{.left_rad = left,
                                     .right_rad = left,
                                     .shaft_rad = left,
                                     .vector = {std::polar(1.5, 0.7), 0.0, 0.4},
                                     .seconds = 20.0};
    drive.seal_into([&](const SealedBlock& block) { shown_.consume(block); });
  }
  WaterfallView shown_{car()};
  const WallTime begin_ = WallClock::now();
};

TEST_F(WaterfallViewTest, TellsTheAmplitudeAtItsOrderInTheClassOfItsSpeed) {
  look();
  drive();
  const auto rows = shown_.rows(begin_);
  ASSERT_EQ(rows.size(), 1U);
  const WaterfallRow& row = rows[0];
  EXPECT_EQ(row.state, OrderState::kComputed);
  EXPECT_EQ(row.of, (WheelChannel{2, {3, 0}}));
  EXPECT_NEAR(row.way_m, 2 * pi * car().wheel[2].rolling_radius_m, 1e-9);
  EXPECT_LE(row.from_m_s, 12.0 * row.way_m);
  EXPECT_GT(row.to_m_s, 12.0 * row.way_m);
  EXPECT_NEAR(row.to_m_s - row.from_m_s, car().drive.speed_class_m_s, 1e-9);
  EXPECT_GT(row.blocks, 10);
  const auto first = static_cast<std::size_t>(std::lround(1.0 / row.step));
  EXPECT_NEAR(row.amplitude[first], 1.5F, 1.5F * 1e-3F);
  EXPECT_LT(row.amplitude[2 * first], 0.01F);
}

TEST_F(WaterfallViewTest, SaysWhyThereIsNothing) {
  look();
  shown_.take({.viewer = 1, .waterfall = {{0, {3, 0}}, {2, {3, 11}}, {2, {77, 0}}}}, begin_);
  int too_short = 0, no_channel = 0;
  for (const WaterfallRow& row : shown_.rows(begin_)) {
    EXPECT_TRUE(row.amplitude.empty());
    too_short += row.state == OrderState::kTooShort ? 1 : 0;
    no_channel += row.state == OrderState::kNoChannel ? 1 : 0;
  }
  EXPECT_EQ(too_short, 1);
  EXPECT_EQ(no_channel, 3) << "a wheel without encoder, no such channel, no such node";
}

TEST_F(WaterfallViewTest, IsForgottenInSilence) {
  look();
  drive();
  EXPECT_TRUE(shown_.rows(begin_ + WaterfallView::kForgotten + 1ms).empty());
  look();
  ASSERT_EQ(shown_.rows(begin_).size(), 1U);
  EXPECT_EQ(shown_.rows(begin_)[0].state, OrderState::kTooShort) << "what was averaged is gone";
}

}  // namespace
}  // namespace roadbalance
