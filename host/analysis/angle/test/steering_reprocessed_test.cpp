// References of a transducer that is fixed to the body, computed again: what steering adds to its angle is
// taken off by the recorded messages on both sides of each instant.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <vector>

#include "common/bus/codec.hpp"
#include "firmware/test/sealed_epoch.hpp"
#include "host/analysis/angle/angle_reprocessor.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr double kRatio = 1.0 / 16.0, kSeconds = 12.0, kDegree = pi / 180.0;

/// 30 degrees of the steering wheel either way, every two seconds.
double steering_rad(double t) {
  return 30.0 * kDegree * std::sin(2 * pi * 0.5 * t);
}
double wheel_rad(double t) {
  return 2 * pi * 18.0 * t;
}

class SteeringAgain : public testing::Test {
 protected:
  SteeringAgain() {
    CanConfig can{
        .interface = "can0", .role = CanRole::kVehicle, .dbc = {}, .accelerometer_id = {}, .signal = {}};
    can.signal.push_back({.name = "steering",
                          .message = "STEER",
                          .signal = "ANGLE",
                          .quantity = SignalQuantity::kSteeringAngle,
                          .wheel = {}});
    vehicle_.node[0].wiring.can.push_back(can);
    vehicle_.wheel[0].encoder.steering_ratio = kRatio;
  }

  void add_messages(double rate_hz, double from_s, double to_s) {
    SignalBlock block;
    SealedBlock sealed;
    const auto send = [&] {
      block.header.node = vehicle_.node[0].id;
      block.header.epoch = test::kEpoch;
      seal(block, sealed);
      blocks_.push_back(sealed);
      block = {};
    };
    for (int k = 0; from_s + k / rate_hz < to_s; ++k) {
      const double t = from_s + k / rate_hz;
      const SignalSample sample{node_time_from_ns(std::llround(1e9 * t)), 0, steering_rad(t)};
      if (block.add(sample)) continue;
      send();
      block.add(sample);
    }
    if (!block.empty()) send();
  }

  struct Judged {
    double most_deg = 0.0;
    int uncertain = 0, blocks = 0;
  };
  /// Angles of the blocks within.  The filter's lag at this speed is in all angles and is taken off as their
  /// mean.
  Judged judge(double from_s, double to_s) {
    AngleReprocessor angles(vehicle_, AngleReprocessor::WithoutMark::kNoAngle,
                            AngleReprocessor::Teeth::kAgain);
    for (const SealedBlock& block : blocks_) angles.learn(block);
    Judged judged;
    std::vector<std::complex<double>> all;
    std::complex<double> mean;
    for (const SealedBlock& block : blocks_) {
      if (block.kind != BlockKind::kScan) continue;
      const ScanBlock scans = decode_scan(angles.reprocess(block));
      const double begin_s = 1e-9 * static_cast<double>(scans.row_time_ns(0));
      if (begin_s < from_s || begin_s >= to_s) continue;
      EXPECT_EQ(scans.quality & kQualityNoReference0, 0) << begin_s;
      ++judged.blocks;
      judged.uncertain += (scans.quality & kQualityUncertainAngle0) != 0 ? 1 : 0;
      for (std::int64_t row = 0; row < scans.header.scans; ++row) {
        const auto& counts = scans.counts[static_cast<std::size_t>(row)];
        const std::complex<double> reference(counts[kAccelerations + 1], counts[kAccelerations]);
        const double t = 1e-9 * static_cast<double>(scans.row_time_ns(row));
        all.push_back(reference * std::polar(1.0, -wheel_rad(t)));
        mean += all.back();
      }
    }
    for (const auto& one : all)
      judged.most_deg = std::max(judged.most_deg, std::abs(std::arg(one / mean)) / kDegree);
    return judged;
  }

  VehicleConfig vehicle_ = test::one_node_vehicle(test::kRate_hz);
  std::vector<SealedBlock> blocks_ = test::blocks_of(
      test::marked_scans(0, static_cast<std::int64_t>(kSeconds* test::kRate_hz), test::kRate_hz),
      sim::PulseTrain{.angle_rad = [](double t) { return wheel_rad(t) + kRatio * steering_rad(t); },
                      .jitter_s = 1e-6}
          .edges(0.0, kSeconds));
};

TEST_F(SteeringAgain, TakesOffWhatSteeringAdds) {
  const std::vector<SealedBlock> without = blocks_;
  for (const double rate_hz : {100.0, 50.0, 20.0}) {
    blocks_ = without;
    add_messages(rate_hz, 0.0, kSeconds);
    const Judged judged = judge(1.0, 11.0);
    std::printf("%3.0f Hz: %.4f degrees at the most\n", rate_hz, judged.most_deg);
    // A straight line is off by a'' / (8 f^2), at 20 Hz 0.006 degrees after the ratio; a pulse by 0.007.
    EXPECT_LT(judged.most_deg, 0.03) << rate_hz;
    EXPECT_EQ(judged.uncertain, 0) << rate_hz;
  }
  vehicle_.wheel[0].encoder.steering_ratio = 0.0;
  EXPECT_NEAR(judge(1.0, 11.0).most_deg, 30.0 / 16.0, 0.05) << "what there was to take off";
}

TEST_F(SteeringAgain, IsUncertainWhereNoMessageTells) {
  const Judged deaf = judge(1.0, 2.0);
  EXPECT_GT(deaf.blocks, 50);
  EXPECT_EQ(deaf.uncertain, deaf.blocks);
  add_messages(50.0, 0.0, 4.0);
  add_messages(50.0, 8.0, kSeconds);
  EXPECT_EQ(judge(1.0, 4.02).uncertain, 0) << "held for three of its periods, 60 ms, from 3.98 s on";
  const Judged silent = judge(4.06, 7.9);
  EXPECT_EQ(silent.uncertain, silent.blocks);
  EXPECT_EQ(judge(8.1, 11.0).uncertain, 0);
}

}  // namespace
}  // namespace roadbalance
