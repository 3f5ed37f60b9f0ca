// A transducer that is fixed to the body gains when the car steers; the node takes it off again.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <vector>

#include "common/bus/codec.hpp"
#include "firmware/epoch_packer.hpp"
#include "firmware/test/butterworth.hpp"
#include "firmware/test/scripted_front_end.hpp"
#include "firmware/test/vehicle.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;
constexpr double kDegree = pi / 180.0;
constexpr double kRate_hz = 2000.0, kTurns_hz = 18.0, kSeconds = 12.0;
constexpr std::array kRatio{1.0 / 16.0, -1.0 / 16.0};  // mounted as mirror images

double steering_rad(double t) {
  return 30.0 * kDegree * std::sin(2 * pi * 0.5 * t);
}

struct Judged {
  double most_deg[kEncoderLines]{}, most_clean_deg = 0.0;  ///< of all blocks; of those that are not flagged
  int uncertain = 0, no_reference = 0, blocks = 0;
};

/// The node's references in [from, to) against the turning wheel behind the filter.
Judged judge(const std::vector<SealedBlock>& blocks, const VehicleConfig& vehicle, double from_s,
             double to_s) {
  Judged judged;
  const double lag = std::arg(test::response(vehicle.filter, kTurns_hz));
  for (const SealedBlock& sealed : blocks) {
    if (sealed.kind != BlockKind::kScan) continue;
    const ScanBlock block = decode_scan(sealed);
    const double start = 1e-9 * static_cast<double>(block.header.time_ns);
    if (start < from_s || start >= to_s) continue;
    ++judged.blocks;
    for (int line = 0; line < kEncoderLines; ++line) {
      judged.no_reference += (block.quality & quality_no_reference(line)) != 0;
      const bool is_uncertain =
          (block.quality & (line == 0 ? kQualityUncertainAngle0 : kQualityUncertainAngle1)) != 0;
      judged.uncertain += is_uncertain;
      for (std::size_t row = 0; row < kScansPerBlock; ++row) {
        const auto sine = static_cast<std::size_t>(kAccelerations + 2 * line);
        const Complex found(block.counts[row][sine + 1], block.counts[row][sine]);
        const double truth = 2 * pi * kTurns_hz * (start + static_cast<double>(row) / kRate_hz) + lag;
        const double off = std::abs(std::arg(found * std::polar(1.0, -truth))) / kDegree;
        judged.most_deg[line] = std::max(judged.most_deg[line], off);
        if (!is_uncertain) judged.most_clean_deg = std::max(judged.most_clean_deg, off);
      }
    }
  }
  return judged;
}

class Steering : public testing::Test {
 protected:
  VehicleConfig vehicle_ = test::one_node_vehicle(kRate_hz, 1000);

  void SetUp() override {
    CanConfig can;
    can.signal = {{"speed", "CAR", "SPEED", SignalQuantity::kVehicleSpeed, ""},
                  {"steering", "STEER", "ANGLE", SignalQuantity::kSteeringAngle, ""}};
    vehicle_.node[0].wiring.can = {can};
    for (std::size_t w = 0; w < kRatio.size(); ++w) vehicle_.wheel[w].encoder.steering_ratio = kRatio[w];
  }

  std::vector<SealedBlock> drive(double message_hz, double silent_from_s, double silent_to_s) {
    std::vector<Edge> edges;
    for (std::uint8_t line = 0; line < kEncoderLines; ++line) {
      const sim::PulseTrain train{
          .angle_rad = [=](double t) { return 2 * pi * kTurns_hz * t + kRatio[line] * steering_rad(t); },
          .teeth = 1000,
          .jitter_s = 1e-6,
          .line = line};
      const auto more = train.edges(0.0, kSeconds);
      edges.insert(edges.end(), more.begin(), more.end());
    }
    std::stable_sort(edges.begin(), edges.end(),
                     [](const Edge& a, const Edge& b) { return a.time < b.time; });
    test::ScriptedFrontEnd device(test::marked_scans(0, static_cast<int>(kSeconds * kRate_hz), kRate_hz),
                                  std::move(edges), 20);
    for (int k = 0; k / message_hz < kSeconds; ++k) {
      const double t = k / message_hz;
      const NodeTime time = node_time_from_ns(std::llround(1e9 * t));
      device.signals.push_back({time, 0, 27.0});
      if (t < silent_from_s || t >= silent_to_s) device.signals.push_back({time, 1, steering_rad(t)});
    }
    std::vector<SealedBlock> blocks;
    pack_epoch(device, vehicle_, vehicle_.node[0], 1,
               [&](const SealedBlock& block) { blocks.push_back(block); });
    return blocks;
  }
};

TEST_F(Steering, IsTakenOffTheReferencesOfBothWheels) {
  for (const double message_hz : {100.0, 50.0, 20.0}) {
    const auto blocks = drive(message_hz, kSeconds, kSeconds);
    const Judged judged = judge(blocks, vehicle_, 2.0, kSeconds - 0.2);
    std::printf("%3.0f Hz: %.4f, %.4f degrees at the most\n", message_hz, judged.most_deg[0],
                judged.most_deg[1]);
    EXPECT_EQ(judged.no_reference, 0);
    EXPECT_EQ(judged.uncertain, 0);
    EXPECT_LT(judged.most_deg[0], 0.02);
    EXPECT_LT(judged.most_deg[1], 0.02);
  }
}

TEST_F(Steering, ThatNoMessageTellsMakesTheAngleUncertain) {
  const auto blocks = drive(50.0, 5.0, 9.0);
  // The last message came at 4.98 s, and is worth something for three periods of 20 ms; the wheel turns at
  // its fastest then.
  EXPECT_EQ(judge(blocks, vehicle_, 2.0, 5.035).uncertain, 0);
  const double turned_on_deg = 30.0 * 2 * pi * 0.5 * 0.060 / 16.0;
  const Judged all = judge(blocks, vehicle_, 2.0, 11.0);
  std::printf("off by %.2f degrees at the most, %.2f where it is not flagged\n", all.most_deg[0],
              all.most_clean_deg);
  EXPECT_LT(all.most_clean_deg, turned_on_deg + 0.02);
  EXPECT_GT(all.most_deg[0], 3.0 * turned_on_deg) << "there is something to flag";
  const Judged silent = judge(blocks, vehicle_, 5.04, 8.98);
  EXPECT_EQ(silent.uncertain, 2 * silent.blocks);
  EXPECT_EQ(silent.no_reference, 0);
  EXPECT_EQ(judge(blocks, vehicle_, 9.02, 11.0).uncertain, 0);

  vehicle_.node[0].wiring.can.clear();
  const Judged deaf = judge(drive(50.0, 0.0, 0.0), vehicle_, 2.0, 11.0);
  EXPECT_EQ(deaf.uncertain, 2 * deaf.blocks) << "a node that never hears of steering";
  EXPECT_NEAR(deaf.most_deg[0], 30.0 / 16.0, 0.02);
}

}  // namespace
}  // namespace roadbalance
