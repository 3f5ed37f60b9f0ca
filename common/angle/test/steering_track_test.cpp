#include "common/angle/steering_track.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "common/angle/wanted_signal.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kMs = 1'000'000;

TEST(SteeringTrack, IsAStraightLineBetweenMessagesAndTheLastOneAfterThem) {
  SteeringTrack track;
  EXPECT_FALSE(track.at(0));
  track.add(100 * kMs, 0.5);
  track.add(200 * kMs, 1.5);
  EXPECT_FALSE(track.at(100 * kMs - 1)) << "nothing is known before the first message";
  EXPECT_NEAR(*track.at(100 * kMs), 0.5, 1e-12);
  EXPECT_NEAR(*track.at(125 * kMs), 0.75, 1e-12);
  EXPECT_NEAR(*track.at(200 * kMs), 1.5, 1e-12);
  EXPECT_NEAR(*track.at(350 * kMs), 1.5, 1e-12);
  EXPECT_FALSE(track.at(350 * kMs + 1)) << "150 ms old";
}

TEST(SteeringTrack, TellsNothingOnceThreePeriodsHavePassedWithoutAMessage) {
  for (const std::int64_t period_ms : {10, 20, 40, 50, 100, 1000}) {
    SteeringTrack track;
    for (int k = 0; k <= 20; ++k) track.add(k * period_ms * kMs, 0.1 * k);
    const std::int64_t last = 20 * period_ms * kMs, worth = std::min(3 * period_ms * kMs, 150 * kMs);
    ASSERT_TRUE(track.at(last + worth)) << period_ms;
    EXPECT_NEAR(*track.at(last + worth), 2.0, 1e-12);
    EXPECT_FALSE(track.at(last + worth + 1)) << period_ms;
    const bool is_line = period_ms <= 150;
    EXPECT_EQ(track.at(last - 1).has_value(), is_line) << period_ms;
  }
}

TEST(SteeringTrack, DrawsNoLineOverASilence) {
  SteeringTrack track;
  track.add(0, 0.0);
  track.add(3'000 * kMs, 3.0);
  EXPECT_NEAR(*track.at(150 * kMs), 0.0, 1e-12);
  EXPECT_FALSE(track.at(150 * kMs + 1));
  EXPECT_FALSE(track.at(1'500 * kMs));
  EXPECT_NEAR(*track.at(3'000 * kMs), 3.0, 1e-12);
}

TEST(SteeringTrack, AwaitsAMessageWhileTheBusSends) {
  SteeringTrack track;
  EXPECT_FALSE(track.is_awaited(0)) << "who knows whether one ever comes";
  track.add(100 * kMs, 0.5);
  EXPECT_FALSE(track.is_awaited(100 * kMs));
  EXPECT_TRUE(track.is_awaited(101 * kMs));
  EXPECT_FALSE(track.is_awaited(1'101 * kMs));
}

TEST(SteeringTrack, PassesOverWhatIsNoYoungerOrNoNumberAndForgetsTheOldest) {
  SteeringTrack track(2);
  track.add(100 * kMs, 1.0);
  track.add(100 * kMs, 7.0);
  track.add(50 * kMs, 7.0);
  track.add(150 * kMs, std::numeric_limits<double>::quiet_NaN());
  track.add(200 * kMs, 2.0);
  EXPECT_NEAR(*track.at(150 * kMs), 1.5, 1e-12);
  track.add(300 * kMs, 3.0);
  EXPECT_FALSE(track.at(150 * kMs));
  EXPECT_NEAR(*track.at(250 * kMs), 2.5, 1e-12);
  EXPECT_THROW(SteeringTrack(1), std::invalid_argument);
}

TEST(SteeringTrack, TakesItsShareOutOfAnglesAndSaysIfItCouldNot) {
  SteeringTrack track;
  for (int k = 0; k <= 10; ++k) track.add(k * 100 * kMs, 0.1 * k);  // 1 rad/s for a second
  std::array<double, 3> angle{10.0, 11.0, 12.0};
  EXPECT_TRUE(track.take_out(0.0625, 250 * kMs, 1e8, angle));
  EXPECT_NEAR(angle[0], 10.0 - 0.0625 * 0.25, 1e-12);
  EXPECT_NEAR(angle[2], 12.0 - 0.0625 * 0.45, 1e-12);
  angle = {10.0, 11.0, 12.0};
  EXPECT_FALSE(track.take_out(0.0625, 5'000 * kMs, 1e8, angle));
  EXPECT_NEAR(angle[1], 11.0 - 0.0625 * 1.0, 1e-12) << "as it was last known";
}

TEST(SteeringTrack, IsToldByTheNodesFirstSignalOfThatQuantity) {
  NodeWiring wiring;
  EXPECT_FALSE(steering_signal(wiring));
  CanConfig can;
  can.signal = {{"speed", "CAR", "SPEED", SignalQuantity::kVehicleSpeed, ""},
                {"steering", "STEER", "ANGLE", SignalQuantity::kSteeringAngle, ""},
                {"other", "STEER", "ANGLE_2", SignalQuantity::kSteeringAngle, ""}};
  wiring.can = {can};
  EXPECT_EQ(steering_signal(wiring), 1);
}

}  // namespace
}  // namespace roadbalance
