#include "host/recorder/control/mark_readings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/bus/codec.hpp"
#include "common/test/source.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kDatum_deg = -107.0, kCycle_s = 10.0;
constexpr int kFrontRight = 1;

/// Turned on by somewhat more than a turn in five seconds, then five of standing.
double by_hand_rad(double time_s) {
  const double cycle = std::floor(time_s / kCycle_s), part = std::min(1.0, (time_s / kCycle_s - cycle) * 2.0);
  return 0.3 + (cycle + part * part * (3.0 - 2.0 * part)) * 381.3 * kDegree;
}

/// The front right wheel of the demonstration car, and who turns and reads it.
class MarkReadingsTest : public testing::Test {
 protected:
  Answer ask(double angle_rad, double reads, int wheel = kFrontRight) {
    return readings.take(
        {.asker = 1, .operation = Operation::kReading, .channel = wheel, .value = {angle_rad, reads}},
        vehicle, now);
  }
  Answer begin(int wheel = kFrontRight) { return ask(0.0, 0.0, wheel); }
  /// Turns it once more and lets it stand.
  void turn(std::int64_t skipped = 0) {
    EdgeBlock block;
    sequence += skipped;
    const auto send = [&] {
      if (block.empty()) return;
      block.header = {1, 77, ++sequence, 0, 0, block.header.time_ns};
      SealedBlock sealed;
      seal(block, sealed);
      readings.take(sealed, now);
      block = {};
    };
    for (const Edge& edge : train.edges(turned * kCycle_s, turned * kCycle_s + 9.9))
      if (!block.add(edge)) {
        send();
        block.add(edge);
      }
    send();
    ++turned;
  }
  /// Its node samples on.
  void wait(milliseconds time = MarkReadings::kStill) {
    now += time;
    ScanBlock scans;
    scans.header = {1, 77, ++sequence, 0, kScansPerBlock, 0};
    scans.period_ps = 500'000'000;
    SealedBlock sealed;
    seal(scans, sealed);
    readings.take(sealed, now);
  }
  /// Somebody reads whole degrees.
  double seen_rad(double off_deg = 0.0) const {
    return std::round(
               std::remainder(by_hand_rad(turned * kCycle_s) / kDegree + kDatum_deg + off_deg, 360.0)) *
           kDegree;
  }
  Answer read(double off_deg = 0.0) {
    wait();
    return ask(seen_rad(off_deg), 1.0);
  }

  const VehicleConfig vehicle =
      VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "vehicle.toml");
  const sim::PulseTrain train{.angle_rad = by_hand_rad, .line = 1};
  MarkReadings readings;
  WallTime now{};
  std::int64_t sequence = 0;
  int turned = 0;
};

TEST_F(MarkReadingsTest, FindWhereTheMarkFires) {
  EXPECT_FALSE(readings.listens());
  EXPECT_EQ(begin().state, AnswerState::kDone);
  EXPECT_TRUE(readings.listens());
  turn();
  const Answer first = read();
  EXPECT_EQ(first.state, AnswerState::kDone) << first.text;
  EXPECT_EQ(first.value[1], 0.0) << "one reading tells no scatter";
  Answer last;
  for (int n = 2; n <= 7; ++n) {
    turn();
    last = read();
    ASSERT_EQ(last.state, AnswerState::kDone) << last.text;
  }
  // A tooth of 3.75 degrees that has not come yet and whole degrees, each evenly spread.
  EXPECT_NEAR(last.value[1] / kDegree, std::sqrt((3.75 * 3.75 + 1.0) / 12.0 / 7), 0.15);
  EXPECT_NEAR(last.value[0] / kDegree, kDatum_deg, 3.0 * last.value[1] / kDegree);
  EXPECT_NE(last.text.find("front_right: 7 readings say -10"), std::string::npos) << last.text;
}

TEST_F(MarkReadingsTest, TakeNoneOfAWheelThatTurnsOrWhoseMarkDidNotFire) {
  EXPECT_EQ(read().reason, RefusalReason::kBadArgument) << "begin first";
  begin();
  now += MarkReadings::kStill;
  EXPECT_EQ(ask(seen_rad(), 1.0).reason, RefusalReason::kNoAnswer) << "no block has come";
  turn();
  EXPECT_EQ(ask(seen_rad(), 1.0).reason, RefusalReason::kMoving);
  wait(MarkReadings::kStill - milliseconds(1));
  EXPECT_EQ(ask(seen_rad(), 1.0).reason, RefusalReason::kMoving);
  EXPECT_EQ(read().state, AnswerState::kDone);
  const Answer again = read();
  EXPECT_EQ(again.reason, RefusalReason::kMoving) << "one mark, one reading";
  EXPECT_NE(again.text.find("turn it forward until it fires"), std::string::npos) << again.text;
  EXPECT_EQ(ask(seen_rad(), 1.0, 0).reason, RefusalReason::kBadArgument) << "another wheel";
  EXPECT_EQ(ask(7.0, 1.0).reason, RefusalReason::kBadArgument) << "more than a turn";
  EXPECT_EQ(ask(std::nan(""), 1.0).reason, RefusalReason::kBadArgument);
}

// It may turn on unheard: no tooth of that would be counted.
TEST_F(MarkReadingsTest, TakeNoneWhileTheNodeIsSilent) {
  begin();
  turn();
  wait();
  now += MarkReadings::kStill;
  const Answer answer = ask(seen_rad(), 1.0);
  EXPECT_EQ(answer.reason, RefusalReason::kNoAnswer);
  EXPECT_EQ(answer.text, "front_right: nothing comes from node front any more");
  EXPECT_EQ(read().state, AnswerState::kDone) << "it is back, and no block was missed";
}

// The mark fires once in a turn and a bit: behind a block that is missed it has not been heard, or nobody
// knows how many teeth have come since.
TEST_F(MarkReadingsTest, CountNoTeethAcrossABlockThatWasMissed) {
  begin();
  turn();
  EXPECT_EQ(read().state, AnswerState::kDone);
  turn();
  SealedBlock sealed;
  EdgeBlock block;
  ASSERT_TRUE(block.add(train.edges(0.0, 5.0).front()));
  sequence += 2;
  block.header = {1, 77, sequence, 0, 0, 0};
  seal(block, sealed);
  readings.take(sealed, now);
  EXPECT_EQ(read().reason, RefusalReason::kMoving);
  turn();
  EXPECT_EQ(read().state, AnswerState::kDone);
}

TEST_F(MarkReadingsTest, DoNotCountAReadingFarFromTheOthers) {
  begin();
  for (int n = 0; n < 3; ++n) {
    turn();
    ASSERT_EQ(read().state, AnswerState::kDone);
  }
  turn();
  const Answer mirrored = read(90.0);
  EXPECT_EQ(mirrored.state, AnswerState::kRefused);
  EXPECT_NE(mirrored.text.find("This reading does not count"), std::string::npos) << mirrored.text;
  turn();
  const Answer good = read();
  EXPECT_EQ(good.state, AnswerState::kDone) << good.text;
  EXPECT_NE(good.text.find("4 readings"), std::string::npos) << good.text;
}

TEST_F(MarkReadingsTest, CountNeitherOfTheFirstTwoIfTheyDisagree) {
  begin();
  turn();
  ASSERT_EQ(read(90.0).state, AnswerState::kDone) << "who knows yet that it is wrong";
  turn();
  const Answer second = read();
  EXPECT_EQ(second.state, AnswerState::kRefused);
  EXPECT_NE(second.text.find("Neither of the two counts"), std::string::npos) << second.text;
  for (int n = 0; n < 2; ++n) {
    turn();
    EXPECT_EQ(read().state, AnswerState::kDone) << n;
  }
  turn();
  const Answer good = read();
  EXPECT_NE(good.text.find("3 readings"), std::string::npos) << good.text;
  EXPECT_NEAR(std::remainder(good.value[0] - kDatum_deg * kDegree, 2.0 * std::numbers::pi), 0.0,
              5.0 * kDegree);
}

TEST_F(MarkReadingsTest, AreOfAWheelThatHasAMark) {
  for (const int wheel : {-1, 4}) EXPECT_EQ(begin(wheel).reason, RefusalReason::kBadArgument) << wheel;
  const VehicleConfig bare = VehicleConfig::parse(
      test::replaced(test::read_source("sim/demo/vehicle.toml"), "zero_mark = true", "zero_mark = false"),
      "vehicle.toml");
  const Answer answer = readings.take({.operation = Operation::kReading, .channel = 0}, bare, now);
  EXPECT_EQ(answer.text, "front_left has no encoder with a zero mark");
  EXPECT_FALSE(readings.listens());
}

}  // namespace
}  // namespace roadbalance
