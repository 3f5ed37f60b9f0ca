#include "host/recorder/control/heard_nodes.hpp"

#include <algorithm>

#include "common/bus/control_messages.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kNodeSilence{3000};

}  // namespace

void HeardNodes::take(std::span<const std::uint8_t> bytes, WallTime now) {
  const auto beat = decode_heartbeat(bytes);
  if (!beat || (!ours_.empty() && std::ranges::find(ours_, beat->node) == ours_.end())) return;
  if (heard_.size() >= kMostNodes && !heard_.contains(beat->node)) return;
  const bool is_last_word = beat->is_over() && beat->base == beat->next;
  heard_[beat->node] = {now, *beat, is_last_word};
}

void HeardNodes::forget(WallTime now) {
  std::erase_if(heard_, [now](const auto& node) { return now - node.second.at > kNodeSilence; });
}

int HeardNodes::count(WallTime now) {
  return static_cast<int>(nodes(now).size());
}

std::vector<std::int32_t> HeardNodes::nodes(WallTime now) {
  return nodes_that(false, now);
}

std::vector<Heartbeat> HeardNodes::heartbeats(WallTime now) {
  forget(now);
  std::vector<Heartbeat> beats;
  for (const auto& [node, heard] : heard_)
    if (!heard.has_left) beats.push_back(heard.beat);
  return beats;
}

std::vector<std::int32_t> HeardNodes::left(WallTime now) {
  return nodes_that(true, now);
}

std::vector<std::int32_t> HeardNodes::nodes_that(bool have_left, WallTime now) {
  forget(now);
  std::vector<std::int32_t> numbers;
  for (const auto& [node, heard] : heard_)
    if (heard.has_left == have_left) numbers.push_back(node);
  return numbers;
}

std::string HeardNodes::who_differs(std::uint32_t vehicle_crc32c, const std::string& file) const {
  for (const auto& [node, heard] : heard_)
    if (!heard.has_left && heard.beat.vehicle_crc32c != vehicle_crc32c)
      return "node " + std::to_string(node) + " measures by another vehicle file than " + file +
             ": choose that file again";
  return "";
}

}  // namespace roadbalance
