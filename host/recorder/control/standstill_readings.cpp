#include "host/recorder/control/standstill_readings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "common/types/block.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kMostBlocks = 4096;
constexpr int kLeastScans = 200;
constexpr std::chrono::seconds kLeastSpan{2};
/// A reference turns with its wheel; noise of a loop-back stays far below this part of full scale.
constexpr std::int64_t kTurning_counts = 1 << 18;

std::string shaking(const ChannelConfig& channel, double rms_m_s2) {
  char text[160];
  std::snprintf(text, sizeof text, "channel %s shakes by %.1f m/s² rms: the car must stand still",
                channel.name.c_str(), rms_m_s2);
  return text;
}

}  // namespace

void StandstillReadings::take(const ScanBlock& preview, WallTime now) {
  const int node = preview.header.node;
  if (nodes_.size() >= kMostNodes && !nodes_.contains(node)) return;
  const auto scans = static_cast<std::size_t>(preview.header.scans);
  if (scans == 0) return;
  Node& known = nodes_[node];
  // Another epoch may have another range or zero: its counts mean something else.
  if (std::exchange(known.epoch, preview.header.epoch) != preview.header.epoch) known.block.clear();
  if (known.block.empty()) std::copy_n(preview.counts[0].begin(), kAccelerations, known.first.begin());
  Block block{.at = now, .scans = static_cast<int>(scans)};
  block.least.fill(INT32_MAX);
  block.most.fill(INT32_MIN);
  for (std::size_t scan = 0; scan < scans; ++scan) {
    const auto& row = preview.counts[scan];
    for (std::size_t k = 0; k < kAccelerations; ++k) {
      const double about_first = static_cast<double>(row[k]) - known.first[k];
      block.sum[k] += about_first;
      block.square[k] += about_first * about_first;
    }
    for (std::size_t k = 0; k < kReferences; ++k) {
      block.least[k] = std::min(block.least[k], row[kAccelerations + k]);
      block.most[k] = std::max(block.most[k], row[kAccelerations + k]);
    }
  }
  known.block.push_back(block);
  while (known.block.size() > kMostBlocks || now - known.block.front().at > kWindow) known.block.pop_front();
}

StandstillReadings::Reading StandstillReadings::of(const NodeConfig& node, WallTime now) const {
  Reading reading;
  const auto known = nodes_.find(node.id);
  Block all;
  all.least.fill(INT32_MAX);
  all.most.fill(INT32_MIN);
  if (known != nodes_.end())
    for (const Block& block : known->second.block) {
      if (now - block.at > kWindow) continue;
      all.scans += block.scans;
      for (std::size_t k = 0; k < kAccelerations; ++k) {
        all.sum[k] += block.sum[k];
        all.square[k] += block.square[k];
      }
      for (std::size_t k = 0; k < kReferences; ++k) {
        all.least[k] = std::min(all.least[k], block.least[k]);
        all.most[k] = std::max(all.most[k], block.most[k]);
      }
    }
  const bool is_long = known != nodes_.end() && !known->second.block.empty() &&
                       now - known->second.block.front().at >= kLeastSpan;
  if (all.scans < kLeastScans || !is_long) {
    reading.fault = "node " + node.name + ": too little has been heard of it: wait three seconds";
    return reading;
  }
  for (std::size_t k = 0; k < kReferences; ++k)
    if (std::int64_t{all.most[k]} - all.least[k] > kTurning_counts)
      reading.fault = "node " + node.name + ": a wheel turns: the car must stand still";
  for (std::size_t k = 0; k < node.channel.size(); ++k) {
    const double mean = all.sum[k] / all.scans;
    const double rms = std::sqrt(std::max(0.0, all.square[k] / all.scans - mean * mean)) *
                       std::abs(node.channel[k].scale_m_s2_per_count);
    if (node.channel[k].role == ChannelRole::kAcceleration && rms > kMostShaking_m_s2 &&
        reading.fault.empty())
      reading.fault = shaking(node.channel[k], rms);
    reading.mean_counts[k] = known->second.first[k] + mean;
  }
  return reading;
}

}  // namespace roadbalance
