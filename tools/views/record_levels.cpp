#include "tools/views/record_levels.hpp"

#include <cmath>
#include <utility>

#include "common/bus/channel_faults.hpp"
#include "common/bus/codec.hpp"
#include "tools/views/degrees.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kInterval_s = 0.1;

/// Slip and drift of the wheels that turned.
Json speeds_json(const WheelSpeeds& speeds) {
  const auto known = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  Json wheels = Json::array(), classes = Json::array();
  const auto all = speeds.wheels();
  for (std::size_t w = 0; w < kWheels; ++w) {
    if (all[w].seconds == 0.0) continue;
    Json drift;
    for (std::size_t other = 0; other < kWheels; ++other)
      if (other != w && all[other].seconds > 0.0)
        drift[kWheelNames[other]] =
            known(degrees(speeds.drift_rad(static_cast<int>(w), static_cast<int>(other))));
    wheels.push_back({{"wheel", kWheelNames[w]},
                      {"seconds", all[w].seconds},
                      {"turns", all[w].turns},
                      {"slip", known(all[w].slip)},
                      {"drift_deg", drift}});
  }
  for (const auto& [place, seconds] : speeds.classes())
    classes.push_back({{"from_m_s", place * speeds.class_m_s()},
                       {"to_m_s", (place + 1) * speeds.class_m_s()},
                       {"seconds", seconds}});
  return {{"wheels", wheels}, {"speed_classes", classes}};
}

}  // namespace

void RecordLevels::NodeLevels::add(const ScanBlock& block, ChannelWatch& watch, LevelsInTime& in_time) {
  whole_.add(block);
  interval_.add(block);
  clipped_ |= static_cast<std::uint32_t>(clipping_.add(block).reached);
  seconds_ += 1e-12 * static_cast<double>(block.period_ps * block.header.scans);
  if (seconds_ < kInterval_s) return;
  seconds_ = 0.0;
  auto level = interval_.take();
  level->clipped = std::exchange(clipped_, 0);
  watch.judge(*level);
  in_time.take(block.header.epoch, *level);
  for (std::size_t c = 0; c < kAccelerations; ++c) {
    if (is_dead(*level, c)) dead_s[c] += level->seconds;
    if (is_clipped(*level, c)) clipped_s[c] += level->seconds;
    if (is_railed(*level, c)) railed_s[c] += level->seconds;
  }
}

void RecordLevels::begin(const VehicleConfig& vehicle) {
  vehicle_ = vehicle;
  watch_.emplace(vehicle_);
  speeds_.emplace(vehicle_);
  for (const auto& node : vehicle_.node) meters_.emplace(node.id, NodeLevels(vehicle_, node));
}

void RecordLevels::consume(const SealedBlock& block) {
  const auto meter = meters_.find(block.header.node);
  if (block.kind == BlockKind::kScan && meter != meters_.end())
    meter->second.add(decode_scan(block), *watch_, in_time_);
}

Json RecordLevels::json() {
  in_time_.flush();
  Json channels = Json::array();
  for (auto& [id, meter] : meters_) {
    const auto level = meter.whole();
    if (!level) continue;
    const NodeConfig& node = *vehicle_.node_with_id(id);
    for (std::size_t c = 0; c < node.channel.size(); ++c)
      channels.push_back({{"channel", node.channel[c].name},
                          {"node", node.name},
                          {"unit", "m/s^2"},
                          {"mean", level->mean[c]},
                          {"rms", level->rms[c]},
                          {"peak", level->peak[c]},
                          {"seconds", level->seconds},
                          {"overload", (level->overload >> c & 1U) != 0},
                          {"clipped_s", meter.clipped_s[c]},
                          {"dead", meter.dead_s[c] > 0.0},
                          {"dead_s", meter.dead_s[c]},
                          {"dc_offset_s", meter.railed_s[c]}});
  }
  Json result{{"channels", channels}};
  result.update(speeds_json(*speeds_));
  return result;
}

}  // namespace roadbalance
