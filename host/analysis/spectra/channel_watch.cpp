#include "host/analysis/spectra/channel_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/bus/channel_faults.hpp"
#include "common/vehicle/gravity.hpp"

namespace roadbalance {
namespace {

constexpr double kUnknownLevel = std::numeric_limits<double>::quiet_NaN();
/// Levels that stay away for longer begin anew: what was in between is not known.
constexpr double kPause_s = 1.0;

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

ChannelWatch::ChannelWatch(const VehicleConfig& vehicle) : vehicle_(vehicle) {
  for (const NodeConfig& node : vehicle_.node) {
    Node& of = node_.emplace(node.id, Node{&node}).first->second;
    of.rms.fill(kUnknownLevel);
    of.mean.fill(kUnknownLevel);
  }
}

/// Puts the interval into the window and takes mean and rms of all that is in it.
void ChannelWatch::add(const Level& level, Node& node) {
  const double now_s = 1e-9 * static_cast<double>(level.time_ns);
  auto& window = node.interval;
  if (!window.empty() && (now_s <= window.back().until_s || now_s - window.back().until_s > kPause_s)) {
    window.clear();
    node.still_until_s = now_s;
  }
  Interval& newest = window.emplace_back(Interval{now_s, level.seconds, {}, {}});
  for (std::size_t c = 0; c < kAccelerations; ++c) {
    newest.mean[c] = level.mean[c];
    newest.square[c] = level.rms[c] * level.rms[c] + level.mean[c] * level.mean[c];
  }
  while (window.size() > 1 && window[1].until_s - window[1].seconds < now_s - kWindow_s) window.pop_front();
  const bool moves = std::ranges::any_of(speed_m_s_, [](const auto& of) { return of.second >= kMoving_m_s; });
  if (!moves) node.still_until_s = now_s;
  const bool whole = now_s - (window.front().until_s - window.front().seconds) >= kWindow_s - 1e-6;
  const bool moved = now_s - node.still_until_s >= kWindow_s - 1e-6;
  for (std::size_t c = 0; c < kAccelerations; ++c) {
    double seconds = 0.0, mean = 0.0, square = 0.0;
    for (const Interval& interval : window) {
      seconds += interval.seconds;
      mean += interval.seconds * interval.mean[c];
      square += interval.seconds * interval.square[c];
    }
    mean /= seconds;
    node.mean[c] = whole ? mean : kUnknownLevel;
    node.rms[c] = whole && moved ? std::sqrt(std::max(0.0, square / seconds - mean * mean)) : kUnknownLevel;
  }
}

/// Median of the others of its kind, or of all others; NaN: there are not two.
double ChannelWatch::usual_rms(const ChannelConfig& channel) const {
  std::vector<double> alike, others;
  for (const auto& [id, node] : node_)
    for (std::size_t c = 0; c < node.config->channel.size(); ++c) {
      const ChannelConfig& other = node.config->channel[c];
      if (&other == &channel || other.role != ChannelRole::kAcceleration || std::isnan(node.rms[c])) continue;
      others.push_back(node.rms[c]);
      if ((other.mount == "body") == (channel.mount == "body")) alike.push_back(node.rms[c]);
    }
  if (alike.size() >= 2) return median(alike);
  return others.size() >= 2 ? median(others) : kUnknownLevel;
}

double ChannelWatch::rail_m_s2(const ChannelConfig& channel) {
  return std::max(kRailShare * channel.range_m_s2, kDriven_m_s2 * channel.direction.head<2>().norm());
}

void ChannelWatch::judge(Level& level) {
  const auto found = node_.find(level.node);
  if (found == node_.end()) return;
  if (!std::isnan(level.speed_m_s))
    speed_m_s_[level.node] = std::abs(level.speed_m_s);
  else
    speed_m_s_.erase(level.node);
  Node& node = found->second;
  add(level, node);
  for (std::size_t c = 0; c < node.config->channel.size(); ++c) {
    const ChannelConfig& channel = node.config->channel[c];
    if (channel.role != ChannelRole::kAcceleration) continue;
    // A comparison with what is not known is false.
    if (node.rms[c] < kDeadShare * usual_rms(channel)) set_dead(level, c);
    double off = std::abs(node.mean[c]);
    if (channel.offset_counts == 0.0)
      off = std::min(off, std::abs(node.mean[c] - kStandardGravity_m_s2 * channel.direction.z()));
    if (off > rail_m_s2(channel)) set_railed(level, c);
  }
}

}  // namespace roadbalance
