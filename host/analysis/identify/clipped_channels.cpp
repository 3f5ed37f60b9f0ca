#include "host/analysis/identify/clipped_channels.hpp"

#include <algorithm>
#include <cmath>

#include "common/text/format.hpp"

namespace roadbalance {

ClippedChannels::ClippedChannels(const NodeConfig& node, std::int32_t channels) : node_(node) {
  for (std::size_t c = 0; c < node.channel.size(); ++c)
    if ((channels >> c & 1) != 0 && node.channel[c].role == ChannelRole::kAcceleration)
      channel_.emplace_back(c, ClippingDetector(node.rate_hz));
}

ClippedChannels::Found ClippedChannels::add(const ScanBlock& block) {
  const bool same = block.header.epoch == epoch_, follows = same && block.header.first_scan == next_scan_;
  epoch_ = block.header.epoch;
  next_scan_ = block.header.first_scan + block.header.scans;
  Found found;
  for (auto& [c, detector] : channel_) {
    if (!same)
      detector.restart();
    else if (!follows)
      detector.skip();
    const auto before = detector.limits();
    bool reached = false;
    for (std::size_t r = 0; r < static_cast<std::size_t>(block.header.scans); ++r) {
      detector.add(block.counts[r][c]);
      reached = reached || detector.limits().reached_by(block.counts[r][c]);
    }
    if (reached) found.reached |= 1 << c;
    const auto& now = detector.limits();
    if ((now.high && !before.high) || (now.low && !before.low)) found.news |= 1 << c;
  }
  return found;
}

std::vector<std::string> ClippedChannels::sentences() const {
  std::vector<std::string> all;
  for (const auto& [c, detector] : channel_)
    if (const auto clause = clipped_clause(node_.channel[c], detector.limits()))
      all.push_back(node_.channel[c].name + " " + *clause +
                    ": what was driven with its tops cut off is not used; choose a larger range, or a sensor "
                    "that has one");
  return all;
}

std::optional<std::string> clipped_clause(const ChannelConfig& channel,
                                          const ClippingDetector::Limits& limits) {
  if (!limits.any()) return std::nullopt;
  std::string at;
  double furthest_m_s2 = 0.0;
  for (const auto& limit : {limits.high, limits.low}) {
    if (!limit) continue;
    const double limit_m_s2 = channel.to_si(*limit);
    at += (at.empty() ? "" : " and ") + format(std::abs(limit_m_s2) < 10.0 ? "%+.1f" : "%+.0f", limit_m_s2);
    furthest_m_s2 = std::max(furthest_m_s2, std::abs(limit_m_s2));
  }
  const bool below = furthest_m_s2 < 0.95 * channel.range_m_s2;
  return "is clipped at " + at + " m/s²" +
         format(below ? ", though its range is %.4g m/s²" : ", the end of its range of %.4g m/s²",
                channel.range_m_s2);
}

}  // namespace roadbalance
