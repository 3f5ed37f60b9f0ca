#include "hil_tests/network/cable.hpp"

namespace roadbalance::test {

void Cable::take(std::size_t from, std::span<const std::uint8_t> frame, WallTime now) {
  const End& sender = ends_.at(from);
  for (std::size_t to = 0; to < ends_.size(); ++to) {
    if (to == from) continue;
    if (!sender.plugged || !ends_[to].plugged) {
      ++counts_.unplugged;
    } else if (happens(sender.faults.loss)) {
      ++counts_.lost;
    } else {
      send(sender.faults, to, frame, now);
      if (!happens(sender.faults.duplicates)) continue;
      ++counts_.duplicated;
      send(sender.faults, to, frame, now);
    }
  }
}

void Cable::send(const CableFaults& faults, std::size_t to, std::span<const std::uint8_t> frame,
                 WallTime now) {
  const std::chrono::microseconds delay(
      std::uniform_int_distribution(faults.shortest.count(), faults.longest.count())(random_));
  under_way_.push({now + delay, number_++, {to, {frame.begin(), frame.end()}}});
}

std::optional<Cable::Frame> Cable::arrived(WallTime now) {
  while (!under_way_.empty() && under_way_.top().due <= now) {
    Frame frame = under_way_.top().frame;
    under_way_.pop();
    if (ends_[frame.to].plugged) {
      ++counts_.carried;
      return frame;
    }
    ++counts_.unplugged;
  }
  return std::nullopt;
}

std::optional<WallTime> Cable::next_arrival() const {
  if (under_way_.empty()) return std::nullopt;
  return under_way_.top().due;
}

}  // namespace roadbalance::test
