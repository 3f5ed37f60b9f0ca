#include "host/recorder/control/turn_over.hpp"

#include <cmath>

#include "common/text/format.hpp"

namespace roadbalance {

TurnOver::Result TurnOver::take(const NodeConfig& node, int channel, bool is_up, double mean_counts,
                                WallTime now) {
  const ChannelConfig& config = node.channel[static_cast<std::size_t>(channel)];
  Reading& reading = read_[{node.id, channel}];
  reading.counts[is_up] = mean_counts;
  reading.at[is_up] = now;
  if (auto& other = reading.counts[!is_up]; other && now - reading.at[!is_up] > kPatience) other.reset();
  const auto [down, up] = reading.counts;
  const std::string name = format("%d.%d %s", node.id, channel + 1, config.name.c_str());
  if (!up || !down)
    return {.text = format(
                "%s reads %+.3f m/s² with its arrow %s: turn it over, let it lie for three seconds, "
                "and read it with its arrow %s",
                name.c_str(), config.to_si(mean_counts), is_up ? "up" : "down", is_up ? "down" : "up")};
  const double difference_m_s2 = (*up - *down) * config.scale_m_s2_per_count;
  const double wanted_m_s2 = 2.0 * kStandardGravity_m_s2;
  if (std::abs(difference_m_s2 / wanted_m_s2 - 1.0) <= kMostOff) {
    const Calibration found{wanted_m_s2 / (*up - *down), 0.5 * (*up + *down)};
    read_.erase({node.id, channel});
    return {.found = found,
            .text = format(
                "channel %s: %.4g m/s² per count, %+.2f %% of what it was; fit it and zero the channels",
                name.c_str(), found.scale_m_s2_per_count,
                100.0 * (found.scale_m_s2_per_count / config.scale_m_s2_per_count - 1.0))};
  }
  read_.erase({node.id, channel});
  const char* why = "is it this channel that was turned over, and does its sensor measure what is steady?";
  if (std::abs(difference_m_s2 / wanted_m_s2 + 1.0) <= kMostOff)
    why = "the arrow pointed the other way each time, or points against the sensor's positive direction.";
  return {
      .is_refused = true,
      .text = format("%s: up and down differ by %.2f m/s², and gravity both ways makes %.2f: %s Begin again.",
                     name.c_str(), difference_m_s2, wanted_m_s2, why)};
}

}  // namespace roadbalance
