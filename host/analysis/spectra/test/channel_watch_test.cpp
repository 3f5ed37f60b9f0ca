#include "host/analysis/spectra/channel_watch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "common/bus/channel_faults.hpp"
#include "common/bus/codec.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "common/types/scan.hpp"
#include "firmware/epoch_packer.hpp"
#include "host/recording/levels.hpp"
#include "sim/front_end.hpp"

namespace roadbalance {
namespace {

using Spoil = std::function<void(ScanBlock&)>;
using Names = std::set<std::string>;

const VehicleConfig& vehicle() {
  static const VehicleConfig demo = VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "demo");
  return demo;
}

/// Levels of both nodes of the simulated car, ten a second, in order of time.
std::vector<Level> drive(double speed_km_h, const Spoil& spoil) {
  const test::TemporaryDirectory folder;
  std::ofstream(folder / "scenario.toml") << "[drive]\n[[drive.plateau]]\nspeed_km_h = " << speed_km_h
                                          << "\nseconds = 14.0\n[road]\nclass = \"A\"\n";
  std::vector<Level> levels;
  for (const NodeConfig& node : vehicle().node) {
    LevelMeter meter(vehicle(), node);
    int blocks = 0;
    const auto front_end =
        sim::open_sim_front_end({folder / "scenario.toml?seed=5&rate=max", vehicle(), node});
    pack_epoch(*front_end, vehicle(), node, 1, [&](const SealedBlock& block) {
      if (block.kind != BlockKind::kScan) return;
      ScanBlock scans = decode_scan(block);
      spoil(scans);
      meter.add(scans);
      if (++blocks % 10 == 0) levels.push_back(*meter.take());
    });
  }
  std::ranges::stable_sort(levels, {}, &Level::time_ns);
  return levels;
}

struct Found {
  Names dead, railed;
  double first_s = INFINITY;  ///< after the beginning
};
Found judge(std::vector<Level> levels) {
  ChannelWatch watch(vehicle());
  Found found;
  for (Level& level : levels) {
    watch.judge(level);
    const NodeConfig& node = *vehicle().node_with_id(level.node);
    for (std::size_t c = 0; c < node.channel.size(); ++c) {
      if (is_dead(level, c)) found.dead.insert(node.channel[c].name);
      if (is_railed(level, c)) found.railed.insert(node.channel[c].name);
      if (is_dead(level, c) || is_railed(level, c))
        found.first_s =
            std::min(found.first_s, 1e-9 * static_cast<double>(level.time_ns - levels.front().time_ns));
    }
  }
  return found;
}

void add_counts(ScanBlock& block, std::size_t channel, double share_of_range) {
  for (auto& row : block.counts) row[channel] += static_cast<std::int32_t>(share_of_range * kFullScaleCounts);
}

/// Output of a converter on an open line: a few counts.
void unplug(ScanBlock& block, std::size_t channel) {
  for (std::size_t r = 0; r < block.counts.size(); ++r)
    block.counts[r][channel] = static_cast<std::int32_t>(r * 7 % 5) - 2;
}

TEST(ChannelWatch, FindsNothingWrongWithAGoodCar) {
  for (const double speed_km_h : {30.0, 108.0}) {
    const Found found = judge(drive(speed_km_h, [](ScanBlock&) {}));
    EXPECT_EQ(found.dead, Names{}) << speed_km_h;
    EXPECT_EQ(found.railed, Names{}) << speed_km_h;
  }
}

TEST(ChannelWatch, NamesTheDeadAndTheRailedChannelAfterThreeSeconds) {
  const std::int32_t front = vehicle().node[0].id;
  const Found found = judge(drive(108.0, [&](ScanBlock& block) {
    if (block.header.node == front) {
      unplug(block, 2);
      add_counts(block, 5, 0.45);  // of 50 m/s^2; 9.81 of it may be gravity, for all that is known
    } else {
      unplug(block, 3);
      add_counts(block, 4, 0.15);  // still within what is allowed
    }
  }));
  EXPECT_EQ(found.dead, (Names{vehicle().node[0].channel[2].name, vehicle().node[1].channel[3].name}));
  EXPECT_EQ(found.railed, Names{vehicle().node[0].channel[5].name});
  EXPECT_GT(found.first_s, 2.7) << "not before the window is full";
}

TEST(ChannelWatch, CallsNothingDeadWhileTheCarStandsOrCrawls) {
  const Found found = judge(drive(10.0, [](ScanBlock& block) {
    unplug(block, 2);
    add_counts(block, 5, -0.3);
  }));
  EXPECT_EQ(found.dead, Names{});
  EXPECT_EQ(found.railed.size(), 2U) << "an offset needs no motion";
}

/// Levels of one node without wheels at a constant mean.
Names railed_at(const NodeConfig& node, const std::vector<double>& mean_m_s2) {
  VehicleConfig car;
  car.node.push_back(node);
  ChannelWatch watch(car);
  Names names;
  for (int k = 1; k <= 50; ++k) {
    Level level{.node = node.id, .time_ns = k * 100'000'000LL, .seconds = 0.1, .speed_m_s = NAN};
    std::ranges::copy(mean_m_s2, level.mean.begin());
    watch.judge(level);
    for (std::size_t c = 0; c < node.channel.size(); ++c)
      if (is_railed(level, c)) names.insert(node.channel[c].name);
  }
  return names;
}

TEST(ChannelWatch, TakesNeitherGravityNorBrakingForAnOffset) {
  NodeConfig node{"cabin", 3, 2000.0, {}};
  for (const auto& [name, direction] : {std::pair{"up", Eigen::Vector3d(0, 0, 1)},
                                        {"down", Eigen::Vector3d(0, 0, -1)},
                                        {"ahead", Eigen::Vector3d(1, 0, 0)}}) {
    ChannelConfig channel;
    channel.name = name;
    channel.mount = "body";
    channel.direction = direction;
    channel.range_m_s2 = 20.0;
    node.channel.push_back(channel);
  }
  EXPECT_EQ(railed_at(node, {9.81, -9.81, 9.0}), Names{}) << "no zero taken, and a hard stop";
  EXPECT_EQ(railed_at(node, {0.5, -0.5, 0.0}), Names{}) << "zeros taken";
  EXPECT_EQ(railed_at(node, {-9.81, -5.0, 11.0}), (Names{"up", "down", "ahead"}));
  node.channel[0].offset_counts = 100.0;
  EXPECT_EQ(railed_at(node, {9.81, 0.0, 0.0}), Names{"up"}) << "its zero was taken with gravity on it";
}

}  // namespace
}  // namespace roadbalance
