// A simulated drive whose pulses jitter badly: what is identified with the angles of the recorded edges is as
// near to the truth as with those computed live, or nearer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <regex>
#include <vector>

#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "firmware/epoch_packer.hpp"
#include "host/analysis/angle/angle_reprocessor.hpp"
#include "host/analysis/identify/drive_estimator.hpp"
#include "sim/front_end.hpp"
#include "sim/truth.hpp"

namespace roadbalance {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

TEST(RefinedDrive, IsIdentifiedAsWellAsLiveOrBetter) {
  const auto vehicle = VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "demo");
  const test::TemporaryDirectory folder;
  const std::string path = folder / "scenario.toml";
  std::ofstream(path) << std::regex_replace(test::read_source("sim/demo/scenario.toml"),
                                            std::regex("stamp_jitter_us = 5.0"), "stamp_jitter_us = 100.0");
  std::vector<std::vector<SealedBlock>> blocks(vehicle.node.size());
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    const auto device =
        sim::open_sim_front_end({path + "?seed=1&seconds=160&rate=max", vehicle, vehicle.node[n]});
    pack_epoch(*device, vehicle, vehicle.node[n], vehicle.node[n].id,
               [&](const SealedBlock& block) { blocks[n].push_back(block); });
  }
  AngleReprocessor angles(vehicle, AngleReprocessor::WithoutMark::kNoAngle, AngleReprocessor::Teeth::kAgain);
  std::size_t most = 0;
  for (const auto& of_node : blocks) {
    for (const SealedBlock& block : of_node) angles.learn(block);
    most = std::max(most, of_node.size());
  }
  DriveEstimator live(vehicle), reprocessed(vehicle);
  for (std::size_t i = 0; i < most; ++i)
    for (const auto& of_node : blocks) {
      if (i >= of_node.size()) continue;
      live.consume(of_node[i]);
      reprocessed.consume(angles.reprocess(of_node[i]));
    }
  const sim::Truth truth = sim::truth_of(path, 1, vehicle);
  const auto before = live.estimate(), after = reprocessed.estimate();
  for (std::size_t w = 0; w < kWheels; ++w) {
    const auto error_deg = [&](const Balance& balance) {
      return std::abs(std::remainder(balance.angle_rad * kDegrees - truth.wheel[w].angle_deg, 360.0));
    };
    const Balance &a = before.balance[w], &b = after.balance[w];
    ASSERT_EQ(a.state, Unknown::kNone);
    ASSERT_EQ(b.state, Unknown::kNone);
    // The angles are good to a hundredth of the degree that the road leaves uncertain.
    EXPECT_LT(error_deg(b), error_deg(a) + 0.05) << kWheelNames[w];
    EXPECT_NEAR(b.unbalance_g, a.unbalance_g, 0.05) << kWheelNames[w];
    const auto quality = angles.quality(static_cast<int>(w));
    ASSERT_TRUE(quality && quality->located);
    // 100 us are 0.6 degrees at 17 turns a second; of 2700 marks the mean is known to a fiftieth of it.
    EXPECT_NEAR(quality->common_sigma_rad * kDegrees, 0.6 / std::sqrt(2700.0), 0.003);
  }
}

}  // namespace
}  // namespace roadbalance
