// The twin of a drive that is under way, on blocks of the simulated car.
#include "host/analysis/twin/live_twin.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "common/test/source.hpp"
#include "firmware/epoch_packer.hpp"
#include "sim/front_end.hpp"
#include "sim/truth.hpp"

namespace roadbalance {
namespace {

constexpr std::uint64_t kSeed = 4;
constexpr int kSeconds = 50;

const VehicleConfig& vehicle() {
  static const VehicleConfig vehicle = [] {
    std::string text = test::read_source("sim/demo/vehicle.toml");
    text = test::replaced(text, "\nrate_hz = 2000", "\nrate_hz = 500");
    text = test::replaced(text, "\ncutoff_hz = 200", "\ncutoff_hz = 100");
    return VehicleConfig::parse(text, "vehicle.toml");
  }();
  return vehicle;
}

/// Scan blocks of each node.
const std::vector<std::vector<SealedBlock>>& blocks() {
  static const std::vector<std::vector<SealedBlock>> blocks = [] {
    std::vector<std::vector<SealedBlock>> all;
    for (const NodeConfig& node : vehicle().node) {
      auto& own = all.emplace_back();
      const auto device = sim::open_sim_front_end(
          {"?seed=" + std::to_string(kSeed) + "&seconds=" + std::to_string(kSeconds) + "&rate=max", vehicle(),
           node});
      pack_epoch(*device, vehicle(), node, node.id, [&](const SealedBlock& block) {
        if (block.kind == BlockKind::kScan) own.push_back(block);
      });
    }
    return all;
  }();
  return blocks;
}

double at_s(const SealedBlock& block) {
  return 1e-9 * static_cast<double>(block.header.time_ns - blocks()[0][0].header.time_ns);
}

struct Second {
  double at_s;
  TwinSecond second;
  bool identified;
};

/// Feeds the drive, the nodes by turns, but for blocks that `lost` names; `at` is asked before each block.
std::vector<Second> drive(const std::function<bool(const SealedBlock&)>& lost,
                          const std::function<void(LiveTwin&, double)>& at) {
  std::vector<Second> seconds;
  LiveTwin* running = nullptr;
  LiveTwin twin(vehicle(), [&](const TwinSecond& second) {
    const double s = 1e-9 * static_cast<double>(second.time_ns - blocks()[0][0].header.time_ns);
    seconds.push_back({s, second, running->car().identified});
  });
  running = &twin;
  for (std::size_t k = 0; k < blocks()[0].size(); ++k)
    for (const auto& node : blocks())
      if (k < node.size() && !lost(node[k])) {
        at(twin, at_s(node[k]));
        twin.consume(node[k]);
      }
  return seconds;
}

bool all_predicted(const TwinSecond& second) {
  for (const auto& channel : second.channel)
    if (channel.account.state != TwinState::kPredicted) return false;
  return true;
}

/// Mean over the carriers of what is left of the band around wheel hop, seconds from .. to.
double residual_share(const std::vector<Second>& seconds, const TwinChannels& channels, double from_s,
                      double to_s) {
  double residual = 0.0, measured = 0.0;
  for (const Second& one : seconds)
    for (std::size_t c = 0; c < channels.channel.size(); ++c)
      if (from_s <= one.at_s && one.at_s < to_s && channels.channel[c].part != TwinPart::kBody) {
        residual += std::pow(one.second.channel[c].account.hop.residual, 2);
        measured += std::pow(one.second.channel[c].account.hop.measured, 2);
      }
  return residual / measured;
}

constexpr auto kNothingLost = [](const SealedBlock&) { return false; };

TEST(LiveTwin, GoesByTheEstimateOnceThereIsOne) {
  const sim::Truth truth = sim::truth_of("", kSeed, vehicle());
  bool estimated = false;
  const auto seconds = drive(kNothingLost, [&](LiveTwin& twin, double s) {
    if (s < 25.0 || estimated) return;
    estimated = true;
    Identification identification;
    identification.state = Unknown::kNone;
    const auto take = [&](int first, auto& values) {
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = truth.car.parameters(first + static_cast<Eigen::Index>(i));
    };
    take(kSpring, identification.spring_n_m);
    take(kDamper, identification.damper_n_s_m);
    take(kStabiliser, identification.stabiliser_n_m);
    take(kTyre, identification.tyre_n_m);
    twin.take(identification);
    for (int w = 0; w < kWheels; ++w) {
      const sim::Truth::Wheel& wheel = truth.wheel[static_cast<std::size_t>(w)];
      Balance balance;
      balance.wheel = w;
      balance.state = Unknown::kNone;
      balance.unbalance_g = wheel.unbalance_g;
      balance.angle_rad = wheel.angle_deg * std::numbers::pi / 180.0;
      twin.take(balance);
    }
  });
  const TwinChannels channels = TwinChannels::of(vehicle());
  ASSERT_GT(seconds.size(), 45U);
  EXPECT_FALSE(all_predicted(seconds.front().second));  // it settles
  // Between two seconds: the one that ends at 25 s, sent 0.64 s later, is the last by vehicle.toml.  Tyres
  // are drawn within 10 % of vehicle.toml: the car that is known now is another, and settles anew.
  int settling = 0;
  for (const Second& one : seconds) {
    EXPECT_EQ(one.identified, one.at_s > 25.5) << one.at_s;
    if (one.at_s > 12.0 && one.at_s < 25.0) {
      EXPECT_TRUE(all_predicted(one.second)) << one.at_s;
    }
    settling += one.at_s > 25.5 && !all_predicted(one.second);
  }
  EXPECT_GE(settling, 3);
  EXPECT_LE(settling, 8);
  // 5 % are left by the road's coherence of 0.95; over 15 s that is known to a few tenths of it.
  EXPECT_LT(residual_share(seconds, channels, 35.0, 50.0), 0.07);
  EXPECT_GT(residual_share(seconds, channels, 12.0, 25.0), 0.10);
}

TEST(LiveTwin, GoesOnWithTheCarItHasIfTheEstimateMovesLikeNone) {
  Identification impossible;
  impossible.state = Unknown::kNone;
  impossible.spring_n_m.fill(30e3);
  impossible.damper_n_s_m.fill(2e3);
  impossible.stabiliser_n_m.fill(-1e6);
  impossible.tyre_n_m.fill(200e3);
  const auto seconds = drive(kNothingLost, [&](LiveTwin& twin, double s) {
    if (s > 20.0) twin.take(impossible);
  });
  ASSERT_GT(seconds.size(), 45U);
  for (const Second& one : seconds) {
    EXPECT_FALSE(one.identified) << one.at_s;
    if (one.at_s > 12.0) {
      EXPECT_TRUE(all_predicted(one.second)) << one.at_s;
    }
  }
}

TEST(LiveTwin, SettlesAnewAfterBlocksThatDidNotCome) {
  const auto lost = [](const SealedBlock& block) {
    return block.header.node == vehicle().node[1].id && at_s(block) > 20.0 && at_s(block) < 21.0;
  };
  const auto seconds = drive(lost, [](LiveTwin&, double) {});
  for (const Second& one : seconds) {
    // There is nothing for the second of the hole: it ends before it, or begins behind it.
    EXPECT_FALSE(one.at_s > 20.01 && one.at_s < 21.99) << one.at_s;
    if (one.at_s > 12.0 && one.at_s < 20.0) {
      EXPECT_TRUE(all_predicted(one.second)) << one.at_s;
    }
    if (one.at_s > 21.9 && one.at_s < 24.0) {
      EXPECT_FALSE(all_predicted(one.second)) << one.at_s;
    }
    if (one.at_s > 32.0) {
      EXPECT_TRUE(all_predicted(one.second)) << one.at_s;
    }
  }
  EXPECT_GT(seconds.size(), 40U);
}

}  // namespace
}  // namespace roadbalance
