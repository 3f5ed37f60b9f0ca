// Two epochs of a wheel whose teeth are counted on the bus: where a mark is known in one, there are angles,
// and none in the other; turned angles are to be had only where no mark is known at all.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "common/bus/codec.hpp"
#include "firmware/test/sealed_epoch.hpp"
#include "host/analysis/angle/angle_reprocessor.hpp"
#include "sim/counter_messages.hpp"

namespace roadbalance {
namespace {

constexpr double kSeconds = 20.0;

double wheel_rad(double t) {
  return 2.0 * std::numbers::pi * 15.0 * t;
}

class CounterAgain : public testing::Test {
 protected:
  CounterAgain() {
    CanConfig can{
        .interface = "can0", .role = CanRole::kVehicle, .dbc = {}, .accelerometer_id = {}, .signal = {}};
    can.signal.push_back({.name = "pulses",
                          .message = "ABS",
                          .signal = "FL",
                          .quantity = SignalQuantity::kPulseCounter,
                          .wheel = "front_left"});
    vehicle_.node[0].wiring.can.push_back(can);
    vehicle_.wheel[0].encoder.counter = "pulses";
  }

  template <typename Block>
  void append(Block block, std::int64_t epoch, std::int64_t time_ns, std::int64_t first = 0,
              std::int64_t scans = 0) {
    block.header = {vehicle_.node[0].id, epoch, ++sequence_, first, scans, time_ns};
    SealedBlock sealed;
    seal(block, sealed);
    blocks_.push_back(sealed);
  }
  /// Scans, the counter, and zero marks each `mark_every` turns; 0: none.
  void add_epoch(std::int64_t epoch, double mark_every) {
    for (const SignalSample& sample : sim::CounterMessages{.angle_rad = wheel_rad}.samples(0.0, kSeconds)) {
      SignalBlock block;
      block.add(sample);
      append(block, epoch, to_ns(sample.time));
    }
    for (double turn = mark_every; turn > 0.0 && turn / 15.0 < kSeconds; turn += mark_every) {
      EdgeBlock block;
      const NodeTime time = node_time_from_ns(std::llround(1e9 * turn / 15.0));
      block.add({time, 0, EdgeKind::kZeroMark});
      append(block, epoch, to_ns(time));
    }
    for (std::int64_t first = 0; first < std::llround(kSeconds * test::kRate_hz); first += kScansPerBlock) {
      ScanBlock block;
      block.period_ps = 500'000'000;
      append(block, epoch, first * 500'000, first, kScansPerBlock);
    }
  }
  /// Seconds of that epoch with a reference, and the reported quality of the wheel.
  double known_s(AngleReprocessor& angles, std::int64_t epoch) {
    double rows = 0.0;
    for (const SealedBlock& block : blocks_) {
      if (block.kind != BlockKind::kScan || block.header.epoch != epoch) continue;
      const ScanBlock scans = decode_scan(angles.reprocess(block));
      if ((scans.quality & kQualityNoReference0) == 0) rows += static_cast<double>(scans.header.scans);
    }
    return rows / test::kRate_hz;
  }
  void learn(AngleReprocessor& angles) const {
    for (const SealedBlock& block : blocks_) angles.learn(block);
  }

  VehicleConfig vehicle_ = test::one_node_vehicle(test::kRate_hz);
  std::vector<SealedBlock> blocks_;
  std::int64_t sequence_ = 0;
};

TEST_F(CounterAgain, NeverMixesAnglesWithTurnedOnes) {
  add_epoch(1, 1.0);
  add_epoch(2, 0.0);
  AngleReprocessor angles(vehicle_, AngleReprocessor::WithoutMark::kTurned);
  learn(angles);
  EXPECT_TRUE(angles.quality(0)->located);
  EXPECT_EQ(angles.quality(0)->contradiction(), "");
  EXPECT_GT(known_s(angles, 1), kSeconds - 1.0);
  EXPECT_EQ(known_s(angles, 2), 0.0);
}

TEST_F(CounterAgain, TellsHowFarTheWheelHasTurnedWhereNoMarkIsKnown) {
  add_epoch(1, 0.0);
  add_epoch(2, 0.0);
  AngleReprocessor angles(vehicle_, AngleReprocessor::WithoutMark::kTurned);
  learn(angles);
  EXPECT_FALSE(angles.quality(0)->located);
  EXPECT_EQ(angles.quality(0)->contradiction(), "") << "there are none";
  EXPECT_GT(known_s(angles, 1), kSeconds - 1.0);
  EXPECT_GT(known_s(angles, 2), kSeconds - 1.0);
  AngleReprocessor none(vehicle_);
  learn(none);
  EXPECT_EQ(known_s(none, 1), 0.0);
}

TEST_F(CounterAgain, SaysWhichMarksSpeakAgainstEachOther) {
  add_epoch(1, 1.0 + 1.0 / 96.0 * 7.0);  // another place each time, 96 / 7 is not whole
  AngleReprocessor angles(vehicle_, AngleReprocessor::WithoutMark::kTurned);
  learn(angles);
  EXPECT_FALSE(angles.quality(0)->located);
  const auto marks = angles.quality(0)->marks + angles.quality(0)->marks_dropped;
  EXPECT_NEAR(static_cast<double>(marks), kSeconds * 15.0 / (1.0 + 7.0 / 96.0), 10.0);
  EXPECT_EQ(angles.quality(0)->contradiction().find("of its " + std::to_string(marks) + " zero marks "), 0U);
}

}  // namespace
}  // namespace roadbalance
