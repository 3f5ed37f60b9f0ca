// The estimate as a drive goes on: when it is asked for, holes, and a car that vehicle.toml describes
// wrongly.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "common/frontend/registry.hpp"
#include "common/test/source.hpp"
#include "firmware/epoch_packer.hpp"
#include "host/analysis/identify/drive_estimator.hpp"
#include "sim/front_end.hpp"

namespace roadbalance {
namespace {

const VehicleConfig& car() {
  static const VehicleConfig vehicle = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  return vehicle;
}

/// 110 s of the demonstration, all blocks of one node behind those of the other.
const std::vector<SealedBlock>& blocks() {
  static const std::vector<SealedBlock> all = [] {
    std::vector<SealedBlock> list;
    for (const NodeConfig& node : car().node) {
      const auto front_end = sim::open_sim_front_end({"?seed=5&seconds=110&rate=max", car(), node});
      pack_epoch(*front_end, car(), node, node.id, [&](const SealedBlock& block) { list.push_back(block); });
    }
    return list;
  }();
  return all;
}

std::complex<double> unbalance_g(const Balance& balance) {
  return std::polar(balance.unbalance_g, balance.angle_rad);
}

TEST(OnlineEstimate, IsANewOneEverySecondAndTheSameWhenItIsAskedForOnceOnly) {
  DriveEstimator asked(car()), quiet(car());
  std::int64_t version = 0, estimates = 0;
  double seconds = 0.0, first_s = 0.0;
  for (const SealedBlock& block : blocks()) {
    quiet.consume(block);
    asked.consume(block);
    if (std::exchange(version, asked.version()) == version) continue;
    const DriveEstimate& now = asked.estimate();
    if (now.identification.state != Unknown::kNone) continue;
    if (++estimates == 1) first_s = seconds = now.identification.seconds_used;
    EXPECT_GE(now.identification.seconds_used, seconds - 1.5) << "sections share a second";
    seconds = now.identification.seconds_used;
  }
  EXPECT_EQ(quiet.version(), asked.version());
  // One for every second of steady driving, but for the first 3 of each section's 9: too short to count.
  EXPECT_GE(static_cast<double>(estimates), (seconds - first_s) * 6.0 / 9.0);
  EXPECT_GT(seconds - first_s, 40.0);
  const DriveEstimate a = asked.estimate(), b = quiet.estimate();
  ASSERT_EQ(a.identification.state, Unknown::kNone);
  EXPECT_EQ(a.identification.time_ns, b.identification.time_ns);
  EXPECT_EQ(a.identification.tyre_n_m, b.identification.tyre_n_m);
  for (std::size_t w = 0; w < kWheels; ++w) {
    EXPECT_EQ(a.balance[w].unbalance_g, b.balance[w].unbalance_g);
    EXPECT_EQ(a.balance[w].covariance_g2, b.balance[w].covariance_g2);
    EXPECT_LE(a.balance[w].sigma_drive_g, a.balance[w].sigma_g);
    EXPECT_LT(a.balance[w].sigma_g, a.balance[w].sigma_alone_g);
    EXPECT_LT(a.balance[w].sigma_force_n, kRadialForceSigma_n) << "the drive tells something of it";
    EXPECT_LT(a.balance[w].force_n, 3.5 * a.balance[w].sigma_force_n) << "there is none";
  }
}

TEST(OnlineEstimate, IsNotBiasedByHoles) {
  DriveEstimator whole(car()), with_holes(car());
  for (const SealedBlock& block : blocks()) {
    const double at_s = 1e-9 * static_cast<double>(block.header.time_ns);
    const bool missing = block.header.node == 1 && std::fmod(at_s, 17.0) < 1.0;
    whole.consume(block);
    if (!missing) with_holes.consume(block);
  }
  const DriveEstimate &all = whole.estimate(), &part = with_holes.estimate();
  ASSERT_EQ(all.identification.state, Unknown::kNone);
  ASSERT_EQ(part.identification.state, Unknown::kNone);
  const double lost = all.identification.seconds_used / part.identification.seconds_used - 1.0;
  ASSERT_GT(lost, 0.05);
  for (std::size_t w = 0; w < kWheels; ++w) {
    const auto off = unbalance_g(part.balance[w]) - unbalance_g(all.balance[w]);
    // The difference of efficient estimates of a part and of the whole has the difference of their variances.
    // Two components: more than 4 sigma of one in 3 of 10000 cases.
    const double variance_g2 = 0.5 * (part.balance[w].covariance_g2 - all.balance[w].covariance_g2).trace();
    ASSERT_GT(variance_g2, 0.0);
    EXPECT_LT(std::abs(off), 4.0 * std::sqrt(variance_g2)) << kWheelNames[w] << ", share lost " << lost;
  }
}

/// The suspension in vehicle.toml is where weights begin, and no more.
TEST(OnlineEstimate, IsTheSameThoughVehicleTomlDescribesTheSuspensionWrongly) {
  VehicleConfig wrong = car();
  for (AxleConfig& axle : wrong.model.axle) {
    axle.damper_n_s_m *= 1.2;
    axle.spring_n_m *= 1.1;
    axle.stabiliser_n_m *= 1.2;
  }
  DriveEstimator by_wrong(wrong), by_right(car());
  for (const SealedBlock& block : blocks()) {
    by_wrong.consume(block);
    by_right.consume(block);
  }
  for (std::size_t w = 0; w < 2; ++w) {  // of 35 and 20 g
    const auto ratio =
        unbalance_g(by_wrong.estimate().balance[w]) / unbalance_g(by_right.estimate().balance[w]);
    EXPECT_NEAR(std::abs(ratio), 1.0, 0.005) << kWheelNames[w];
    EXPECT_NEAR(std::arg(ratio) * 180.0 / std::numbers::pi, 0.0, 0.3) << kWheelNames[w];
  }
}

}  // namespace
}  // namespace roadbalance
