#include "tools/views/readout.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "tools/views/clock_line.hpp"
#include "tools/views/compensation_json.hpp"
#include "tools/views/order_lines.hpp"
#include "tools/views/sealing_rate.hpp"
#include "tools/views/watch_json.hpp"
#include "tools/views/watch_lines.hpp"

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Balance known(double grams, double degrees) {
  Balance balance;
  balance.wheel = 0;
  balance.state = Unknown::kNone;
  balance.unbalance_g = grams;
  balance.angle_rad = degrees * kDegree;
  balance.sigma_g = 2.0;
  balance.sigma_rad = 2.6 * kDegree;
  balance.covariance_g2 = Eigen::Matrix2d::Identity() * 4.0;
  return balance;
}

TEST(BalanceLine, SaysHeavySpotMassAndHowSure) {
  EXPECT_EQ(balance_line(known(35.0, 217.0)), "front left:  heavy spot 217°, 35.0 g, ± 2.0 g ± 3°");
  EXPECT_EQ(balance_line(known(35.0, 359.7)), "front left:  heavy spot   0°, 35.0 g, ± 2.0 g ± 3°");
}

TEST(BalanceLine, ClaimsNothingExactlyAndNoAngleWorseThanNone) {
  Balance balance = known(35.0, 217.0);
  balance.sigma_g = 0.004;
  EXPECT_EQ(balance_line(balance), "front left:  heavy spot 217°, 35.0 g, ± 0.1 g ± 3°");
  balance.sigma_rad = 9.0;
  EXPECT_EQ(balance_line(balance), "front left:  heavy spot 217°, 35.0 g, ± 0.1 g ± 180°");
}

TEST(BalanceLine, ShowsAnAngleThatIsNoneAsNone) {
  Balance balance = known(35.0, 217.0);
  balance.angle_rad = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(balance_line(balance), "front left:  heavy spot nan°, 35.0 g, ± 2.0 g ± 3°");
  EXPECT_EQ(balance_line(known(35.0, -0.3)), "front left:  heavy spot   0°, 35.0 g, ± 2.0 g ± 3°");
}

/// A line cut at so many bytes would end amid a character.
TEST(OrderLines, ShowNumbersOfAnyLengthWhole) {
  OrderReport report{.wheel = 1, .node = 2};
  report.order[0][3] = {{1e300, 0.0}, 1e300, 0.1, 40};
  const auto lines = order_lines(report);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(lines[0].ends_with(".0000 m/s²  0.0 ± 5.7 deg  40 blocks")) << lines[0];
}

TEST(BalanceLine, SaysWhyItIsNotKnown) {
  Balance balance;
  balance.wheel = 3;
  balance.state = Unknown::kTooSlow;
  EXPECT_EQ(balance_line(balance), "rear right:  not known: the car never went fast enough");
  EXPECT_TRUE(advice_lines(balance, {}).empty());
}

TEST(NodeLine, SaysWhatANodeCounts) {
  Heartbeat beat;
  beat.node = 2;
  beat.scans_sampled = 12'000;
  beat.scans_missing = 3;
  beat.blocks_repaired = 7;
  beat.ring_used = 50;
  beat.ring_capacity = 1'000;
  EXPECT_EQ(node_line(beat, std::nullopt),
            "node 2: 12000 samples taken, 3 missing, 7 blocks repaired, memory 5 % full, obeys no recorder");
  EXPECT_TRUE(node_json(beat, std::nullopt).at("owner").is_null());
  EXPECT_TRUE(node_json(beat, std::nullopt).at("memory_left_s").is_null());
}

TEST(NodeLine, SpeaksOfItsDiskItsMemoryAndWhomItObeys) {
  Heartbeat beat;
  beat.node = 1;
  beat.owner = 4711;
  beat.ring_capacity = 200;
  beat.ring_used = 150;
  beat.spool_used = 40;
  beat.spool_failures = 2;
  EXPECT_EQ(
      node_line(beat, 12.4),
      "node 1: 0 samples taken, 0 missing, 0 blocks repaired, memory 75 % full, lasts 12 s, 40 blocks on "
      "its disk, ITS DISK REFUSED 2 times, obeys recorder 4711");
  const auto json = node_json(beat, 12.4);
  EXPECT_EQ(json.at("owner"), 4711);
  EXPECT_EQ(json.at("blocks_on_disk"), 40);
  EXPECT_EQ(json.at("disk_failures"), 2);
  EXPECT_EQ(json.at("memory_left_s"), 12.4);
}

// 100 blocks a second; 16000 blocks are free.
TEST(SealingRate, SaysHowLongTheMemoryLasts) {
  Heartbeat beat;
  beat.epoch = 5;
  beat.ring_capacity = 20'000;
  beat.ring_used = 4'000;
  SealingRate rate;
  for (int k = 0; k <= 30; ++k) {
    beat.time_ns = 7'000'000'000 + 100'000'000LL * k;
    beat.next = 1 + 10 * k;
    rate.take(beat);
    EXPECT_EQ(rate.seconds_left(beat).has_value(), k >= 20) << k;
  }
  EXPECT_NEAR(*rate.seconds_left(beat), 160.0, 1e-6);
  beat.epoch = 6;  // started again: nothing is known of it
  rate.take(beat);
  EXPECT_FALSE(rate.seconds_left(beat));
}

TEST(SealingRate, OfANodeThatSealsNothingIsNotKnown) {
  Heartbeat beat;
  beat.ring_capacity = 100;
  SealingRate rate;
  for (int k = 0; k <= 30; ++k) {
    beat.time_ns = 100'000'000LL * k;
    rate.take(beat);
  }
  EXPECT_FALSE(rate.seconds_left(beat));
}

TEST(ClockLine, SaysHowSureTheClockIs) {
  ClockFit fit;
  fit.node = 3;
  fit.exchanges = 4;
  fit.unanswered = 2;
  EXPECT_EQ(clock_line(fit), "node 3 clock not known yet: 4 answers, 2 questions without");
  EXPECT_TRUE(clock_json(fit).at("uncertainty_s").is_null());
  fit.state = ClockState::kHoldover;
  fit.uncertainty_s = 12.34e-6;
  fit.drift = -4.5e-6;
  fit.round_trip_s = 80e-6;
  fit.breaks = 1;
  EXPECT_EQ(clock_line(fit),
            "node 3 clock held over to 12.3 us, drift -4.50 ppm, round trip 80.0 us, breaks 1");
  EXPECT_EQ(clock_json(fit).at("state"), "holdover");
  EXPECT_EQ(clock_json(fit).at("uncertainty_s"), 12.34e-6);
}

TEST(RecorderLines, NameItsAlarms) {
  RecorderStatus status;
  status.incarnation = 8;
  status.segment = 3;
  status.bytes_recorded = 1'200'000'000;
  status.bytes_free = 34'000'000'000;
  auto lines = recorder_lines(status, {});
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0], "recorder 8: records to segment 3: 1.2 GB so far, 34 GB free");
  EXPECT_TRUE(recorder_json(status).at("alarms").empty());
  EXPECT_TRUE(recorder_json(status).at("seconds_left").is_null());
  status.state = RecorderState::kDiskFull;
  status.waiting_blocks = 12;
  lines = recorder_lines(status, {});
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NE(lines[1].find("!!! ALARM: THE DISK IS FULL: 12 blocks wait"), std::string::npos) << lines[1];
  EXPECT_EQ(recorder_json(status).at("state"), "disk_full");
  EXPECT_EQ(recorder_json(status).at("alarms").size(), 1u);
}

TEST(RecorderLines, OfOneThatNoNodeObeysSayWhomTheyObey) {
  RecorderStatus status;
  status.incarnation = 9;
  std::map<std::int32_t, Heartbeat> beats;
  beats[1].owner = 8;
  const auto refused = recorder_lines(status, beats);
  ASSERT_EQ(refused.size(), 2u);
  EXPECT_EQ(refused[1], "  ! records nothing of node 1, which obeys recorder 8");
  beats[1].owner = 9;
  EXPECT_EQ(recorder_lines(status, beats).size(), 1u);
}

/// One weight added, one moved; what is left is within a limit and beyond another.
Compensation two_steps() {
  Compensation found{.advice = Advice::kSteps};
  found.plan.step = {{WeightAction::kAdd, {15.0, 37.0 * kDegree, {0.19}}, {}},
                     {WeightAction::kMove, {5.0, 90.0 * kDegree, {0.16}}, {5.0, 10.0 * kDegree, {0.19}}}};
  found.verdict = {.residual_g = 1.26,
                   .shop_g = 7.0,
                   .permissible_g = 1.0,
                   .permissible_grade_mm_s = 40.0,
                   .grade_mm_s = 50.0};
  return found;
}

Balance driven() {
  Balance balance = known(30.0, 217.0);
  balance.least_speed_m_s = 25.0;
  balance.greatest_speed_m_s = 36.0;
  return balance;
}

TEST(AdviceLines, SayWhatToDoAndWhatThatLeaves) {
  const auto lines = advice_lines(driven(), two_steps());
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "  add 15 g at 37°, move 5 g from 10° to 90°");
  EXPECT_EQ(
      lines[1],
      "  leaves 1.3 g, within what a shop leaves (7 g), ISO G 50 BEYOND G 40 (1 g by the unsprung mass); "
      "at 90–130 km/h");
  Compensation by_rotor = two_steps();
  by_rotor.verdict.by_rotor = true;
  EXPECT_NE(advice_lines(driven(), by_rotor)[1].find("BEYOND G 40 (1 g); at 90"), std::string::npos);
}

TEST(AdviceLines, SayTheRadiusIfThereIsMoreThanOne) {
  Compensation found = two_steps();
  found.radii = 2;
  EXPECT_EQ(advice_lines(driven(), found)[0],
            "  add 15 g at 37° on 190 mm, move 5 g from 10° on 190 mm to 90° on 160 mm");
}

TEST(AdviceLines, SayHowAWeightHoldsAndOnWhichSide) {
  Compensation found = two_steps();
  found.plan.step[0].weight.place = {0.19, WeightKind::kAdhesive, RimPlane::kInner};
  found.plan.step[1].weight.place = {0.19, WeightKind::kClip, RimPlane::kInner};
  found.plan.step[1].from.place = {0.19, WeightKind::kClip, RimPlane::kOuter};
  EXPECT_EQ(
      advice_lines(driven(), found)[0],
      "  stick 15 g at 37° in the inner plane, move the 5 g clip from 10° on the outer flange to 90° on the "
      "inner flange");
  std::array<Balance, kWheels> balance;
  std::array<Compensation, kWheels> compensation;
  compensation[1] = found;
  const auto steps = compensation_json(balance, compensation)[1]["steps"];
  EXPECT_EQ(steps[0]["kind"], "adhesive");
  EXPECT_EQ(steps[0]["plane"], "inner");
  EXPECT_EQ(steps[1]["kind"], "clip");
  EXPECT_EQ(steps[1]["from_plane"], "outer");
  compensation[1] = two_steps();
  EXPECT_TRUE(compensation_json(balance, compensation)[1]["steps"][0]["kind"].is_null()) << "nobody told it";
}

TEST(AdviceLines, SayWhenAWheelIsToBeLeftAlone) {
  Compensation found{.advice = Advice::kLeaveUncertain};
  found.verdict = {.residual_g = 8.0, .shop_g = 7.0};
  const auto lines = advice_lines(driven(), found);
  EXPECT_EQ(lines[0], "  leave it: the unbalance is within its own uncertainty");
  EXPECT_EQ(lines[1].rfind("  leaves 8.0 g, MORE THAN what a shop leaves (7 g); at 90–130 km/h", 0), 0u)
      << lines[1];
  found.advice = Advice::kLeaveSmall;
  EXPECT_EQ(advice_lines(driven(), found)[0], "  leave it: no weight there is makes it enough less");
}

TEST(AdviceLines, SayThatWeightsWillNotCureIt) {
  Compensation found = two_steps();
  found.verdict.incurable = "force dominates";
  EXPECT_EQ(advice_lines(driven(), found).at(2), "  WEIGHTS WILL NOT CURE THIS: force dominates");
}

TEST(CompensationJson, HoldsTheStepsAndIsNullWhereNothingIsKnown) {
  std::array<Balance, kWheels> balance;
  std::array<Compensation, kWheels> compensation;
  balance[1] = driven();
  compensation[1] = two_steps();
  const auto json = compensation_json(balance, compensation);
  EXPECT_TRUE(json[0]["advice"].is_null());
  EXPECT_TRUE(json[0]["steps"].is_null());
  EXPECT_EQ(json[1]["advice"], "steps");
  EXPECT_EQ(json[1]["of"], "correction");
  EXPECT_NEAR(json[1]["greatest_speed_km_h"].get<double>(), 129.6, 1e-9);
  EXPECT_EQ(json[1]["within_shop"], true);
  EXPECT_TRUE(json[1]["incurable"].is_null());
  const auto& steps = json[1]["steps"];
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0]["action"], "add");
  EXPECT_NEAR(steps[0]["angle_deg"].get<double>(), 37.0, 1e-9);
  EXPECT_FALSE(steps[0].contains("from_deg"));
  EXPECT_NEAR(steps[1]["from_deg"].get<double>(), 10.0, 1e-9);
  EXPECT_EQ(steps[1]["from_radius_m"], 0.19);
}

TEST(LevelLines, MarkDeadClippedAndOverloadedChannels) {
  Level level;
  level.node = 2;
  level.speed_m_s = 100.0 / 3.6;
  level.dead = 1U << 3 | 1U << (16 + 7);
  level.overload = 1U << 5;
  level.clipped = 1U << 9;
  const auto lines = level_lines(level);
  ASSERT_EQ(lines.size(), 1U + kAccelerations);
  EXPECT_EQ(lines[0], "node 2: 100.0 km/h");
  EXPECT_NE(lines[4].find("DEAD"), std::string::npos);
  EXPECT_NE(lines[6].find("OVERLOAD"), std::string::npos);
  EXPECT_NE(lines[8].find("DC OFFSET"), std::string::npos);
  EXPECT_EQ(lines[8].find("DEAD"), std::string::npos);
  EXPECT_NE(lines[10].find("CLIPPED"), std::string::npos);
  EXPECT_EQ(lines[6].find("CLIPPED"), std::string::npos);
  EXPECT_EQ(lines[5].find("DEAD"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
