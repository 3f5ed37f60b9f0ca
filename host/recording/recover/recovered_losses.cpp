#include "host/recording/recover/recovered_losses.hpp"

namespace roadbalance {
namespace {

// Each block begins with the fingerprint, its node and its epoch, big endian.
constexpr std::size_t kNodeAt = 8, kEpochAt = 12, kEpochEnd = 20;

std::int64_t number_at(std::span<const std::uint8_t> bytes) {
  std::uint64_t number = 0;
  for (const std::uint8_t byte : bytes) number = number << 8 | byte;
  return static_cast<std::int64_t>(number);
}

}  // namespace

void RecoveredLosses::altered_block(const LogEvent& event) {
  NodeEpoch named;  // no node's
  if (event.data.size() >= kEpochEnd) {
    named.first = static_cast<std::int32_t>(number_at(event.data.subspan(kNodeAt, kEpochAt - kNodeAt)));
    named.second = number_at(event.data.subspan(kEpochAt, kEpochEnd - kEpochAt));
  }
  ++blocks_[named];
}

void RecoveredLosses::deleted_segments(const std::string& folder, SegmentRun run) {
  listed_.push_back(in_words(run) + " of " + folder + ", which the retention mode had deleted");
}

std::vector<std::string> RecoveredLosses::lines(const std::function<bool(const NodeEpoch&)>& is_held) const {
  std::vector<std::string> lines = listed_;
  const auto add = [&lines](auto count, const char* what) {
    if (count > 0) lines.push_back(std::to_string(count) + what);
  };
  std::int64_t blocks = 0;
  for (const auto& [epoch, count] : blocks_) blocks += is_held(epoch) ? 0 : count;
  add(segments_, " segments that are missing or not as they were finished");
  add(bytes_, " bytes that are no events");
  add(entries_, " altered entries: notes, clocks, journal or commits");
  add(headers_, " stretches of events of which one is altered: number, stamp or channel, or contents with their CRC");
  add(blocks, " altered blocks, of epochs of which no other is there");
  return lines;
}

}  // namespace roadbalance
