#include "firmware/commands.hpp"

#include <algorithm>

namespace roadbalance {

namespace {
constexpr std::size_t kKnownReplies = 64;
constexpr std::size_t kMostUnsent = 64;
}  // namespace

Commands::Commands(std::int32_t node, std::int64_t epoch, const Backlog& backlog, Sender& sender,
                   AcquireLink& link, VehicleChange& vehicle)
    : node_(node), epoch_(epoch), backlog_(backlog), sender_(sender), link_(link), vehicle_(vehicle) {}

bool Commands::ended() const {
  const NodeState state = link_.state.load(std::memory_order_acquire);
  return state == NodeState::kEnded || state == NodeState::kFailed;
}

void Commands::take(const Command& command, WallTime now) {
  if (command.node != node_ || (command.epoch != 0 && command.epoch != epoch_) ||
      to_send_.size() >= kMostUnsent)
    return;
  if (command.verb == Verb::kConfigure) return configure(command, now);
  take_instant(command, now);
  const auto known = std::find_if(known_.begin(), known_.end(),
                                  [&](const Reply& reply) { return reply.request == command.request; });
  if (known != known_.end()) {
    to_send_.push_back(*known);
    return;
  }
  if (stop_request_ && stop_request_->request == command.request) return;
  const CommandError result = act(command, now);
  if (command.verb == Verb::kStop && result == CommandError::kNone)
    stop_request_ = command;
  else if (command.verb == Verb::kClaim && result != CommandError::kNone)
    answer(command, result, std::min(sender_.highest_owner(), kIndexLimit));
  else
    answer(command, result, command.verb == Verb::kStart ? 1 : backlog_.next());
}

bool Commands::is_owner(const Command& command) const {
  return command.incarnation == sender_.owner() && sender_.owner() != 0;
}

void Commands::take_instant(const Command& command, WallTime now) {
  const bool starts = command.verb == Verb::kStart && !ended() && !vehicle_.wanted();
  if (!is_owner(command) || !(starts || command.verb == Verb::kStop)) return;
  auto& instant = starts ? link_.start_at : link_.stop_at;
  const WallTime at = now + std::chrono::microseconds(command.delay_us);
  instant.store(std::min(at, instant.load(std::memory_order_relaxed)), std::memory_order_release);
}

CommandError Commands::act(const Command& command, WallTime now) {
  const bool owner = is_owner(command);
  switch (command.verb) {
    case Verb::kClaim:
      return sender_.claim(command.incarnation, now) ? CommandError::kNone : CommandError::kNotOwner;
    case Verb::kRelease:
      return sender_.release(command.incarnation) ? CommandError::kNone : CommandError::kNotOwner;
    case Verb::kStart:
      if (!owner) return CommandError::kNotOwner;
      if (ended() || vehicle_.wanted()) return CommandError::kEnded;
      return CommandError::kNone;
    case Verb::kStop:
      if (!owner) return CommandError::kNotOwner;
      return CommandError::kNone;
    case Verb::kConfigure:
      break;
  }
  return CommandError::kUnknownVerb;
}

// Its answers are not kept here: a request refused now may succeed later, and a done one is known to the
// epoch after.  Only between recordings: nothing that was sampled may be lost for it.  An owner whose release
// was lost is not waited for.
void Commands::configure(const Command& command, WallTime now) {
  auto outcome = vehicle_.outcome(command.request);
  if (!outcome) {
    const bool is_idle = link_.state.load(std::memory_order_acquire) == NodeState::kPreview &&
                         link_.start_at.load() == AcquireLink::kNotAsked;
    const bool obeys = !sender_.is_led(now) || command.incarnation == sender_.owner();
    if (!obeys)
      outcome = {CommandError::kNotOwner, "the node obeys another recorder"};
    else if (!is_idle)
      outcome = {CommandError::kMeasuring, "the node is measuring"};
    else
      outcome = vehicle_.ask(command);
  }
  if (outcome)
    to_send_.push_back({node_, epoch_, command.request, outcome->result, backlog_.next(), outcome->why});
}

void Commands::answer(const Command& command, CommandError result, std::int64_t sequence) {
  const Reply reply{node_, epoch_, command.request, result, sequence, {}};
  known_.push_back(reply);
  if (known_.size() > kKnownReplies) known_.pop_front();
  to_send_.push_back(reply);
}

std::optional<Reply> Commands::next_reply() {
  if (stop_request_ && ended()) {
    const Command request = *stop_request_;
    stop_request_.reset();
    answer(request, CommandError::kNone, backlog_.next() - 1);
  }
  if (to_send_.empty()) return std::nullopt;
  const Reply reply = to_send_.front();
  to_send_.pop_front();
  return reply;
}

}  // namespace roadbalance
