#include "host/recorder/control/vehicle_push.hpp"

#include <algorithm>
#include <utility>

#include "common/types/text_crc.hpp"

namespace roadbalance {

VehiclePush::VehiclePush(std::string before, std::string after, const std::vector<std::int32_t>& nodes,
                         std::int64_t incarnation, std::uint64_t seed, WallTime now)
    : before_(std::move(before)),
      after_(std::move(after)),
      incarnation_(incarnation),
      random_(seed),
      begun_(now) {
  for (const std::int32_t node : nodes) nodes_[node].request = new_request();
  if (nodes_.empty()) state_ = State::kDone;
}

VehiclePush::Due VehiclePush::due(WallTime now) {
  Due due;
  if (state_ != State::kUnderWay) return due;
  if (std::exchange(restarts_, false)) begun_ = now;
  if (now - begun_ > kPatience) {
    if (undoes_) {
      end_undoing();
      return due;
    }
    const auto silent = std::ranges::find_if(nodes_, [](const auto& n) { return !n.second.has_answered; });
    const std::string who = "node " + std::to_string(silent->first);
    if (const std::string waits_for = silent->second.waits_for; !waits_for.empty())
      undo(State::kRefused, who + ": " + waits_for);
    else
      undo(State::kSilent, who + " does not answer");
    begun_ = now;
    restarts_ = false;
    if (state_ != State::kUnderWay) return due;
  }
  if (was_reported_ && now - reported_at_ < kRepeat) return due;
  was_reported_ = true;
  reported_at_ = now;
  const std::string& text = wanted();
  const auto parts = static_cast<std::int32_t>((text.size() + kMostVehiclePart - 1) / kMostVehiclePart);
  for (const auto& [number, node] : nodes_) {
    if (node.has_answered) continue;
    for (std::int32_t part = 0; part < parts; ++part)
      due.part.push_back(
          {.node = number,
           .incarnation = incarnation_,
           .vehicle_crc32c = crc32c(text),
           .part = part,
           .parts = parts,
           .text = text.substr(static_cast<std::size_t>(part) * kMostVehiclePart, kMostVehiclePart)});
    due.command.push_back({.node = number,
                           .request = node.request,
                           .incarnation = incarnation_,
                           .verb = Verb::kConfigure,
                           .vehicle_crc32c = crc32c(text)});
  }
  return due;
}

void VehiclePush::take(const Reply& reply) {
  if (state_ != State::kUnderWay) return;
  const auto found = nodes_.find(reply.node);
  if (found == nodes_.end() || found->second.request != reply.request) return;
  Node& node = found->second;
  // Parts come again; and a recording whose last blocks are still being repaired is soon over.
  if (reply.result == CommandError::kVehicleMissing || reply.result == CommandError::kMeasuring) {
    node.waits_for = reply.text;
    return;
  }
  // A recorder that went away may be obeyed for some seconds yet: what has the new text must lose it again.
  if (undoes_ && reply.result == CommandError::kNotOwner) {
    node.waits_for = reply.text;
    node.request = new_request();
    return;
  }
  node.has_answered = true;
  node.has_taken = reply.result == CommandError::kNone;
  node.waits_for = reply.text;
  if (!undoes_ && !node.has_taken)
    return undo(State::kRefused, "node " + std::to_string(reply.node) + ": " + reply.text);
  if (std::ranges::all_of(nodes_, [](const auto& n) { return n.second.has_answered; })) {
    if (undoes_)
      end_undoing();
    else
      state_ = outcome_;
  }
}

void VehiclePush::undo(std::string why) {
  if (state_ != State::kDone) return;
  state_ = State::kUnderWay;
  undo(State::kRefused, std::move(why));
}

// Who has not taken the old text may measure by the new one.
void VehiclePush::end_undoing() {
  state_ = outcome_;
  for (const auto& [number, node] : nodes_) {
    if (node.has_taken) continue;
    why_ += "; node " + std::to_string(number) + " may keep the new set-up";
    if (!node.waits_for.empty()) why_ += " (" + node.waits_for + ")";
  }
}

std::int64_t VehiclePush::new_request() {
  return static_cast<std::int64_t>(random_() >> 1) | 1;
}

// Who has not answered yet may still take it: it is asked, too.  Who refuses measures by the old text, unless
// that is what it refuses: a change of a recorder before is undone by one whose both texts are the same.
void VehiclePush::undo(State outcome, std::string why) {
  undoes_ = true;
  outcome_ = outcome;
  why_ = std::move(why);
  was_reported_ = false;
  restarts_ = true;
  const auto refuses = [](const Node& node) { return node.has_answered && !node.has_taken; };
  if (before_ != after_) std::erase_if(nodes_, [&](const auto& node) { return refuses(node.second); });
  for (auto& [number, node] : nodes_)
    node = refuses(node) ? Node{.has_answered = true} : Node{.request = new_request()};
  if (std::ranges::all_of(nodes_, [](const auto& n) { return n.second.has_answered; })) end_undoing();
}

}  // namespace roadbalance
