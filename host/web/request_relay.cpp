#include "host/web/request_relay.hpp"

#include <algorithm>

namespace roadbalance {

void RequestRelay::take(const Request& request, WallTime now) {
  const auto same = std::ranges::find_if(asked_, [&](const Asked& asked) {
    return asked.request.asker == request.asker && asked.request.request == request.request;
  });
  if (same != asked_.end()) return;
  if (asked_.size() >= kMost) asked_.erase(asked_.begin());
  asked_.push_back({.request = request, .since = now});
}

void RequestRelay::take(const Answer& answer) {
  if (answer.state == AnswerState::kUnderWay) return;
  std::erase_if(asked_, [&](const Asked& asked) {
    return asked.request.asker == answer.asker && asked.request.request == answer.request;
  });
}

std::vector<Request> RequestRelay::due(WallTime now) {
  std::erase_if(asked_, [now](const Asked& asked) { return now - asked.since > kPatience; });
  std::vector<Request> requests;
  for (Asked& asked : asked_) {
    if (asked.was_sent && now - asked.sent_at < kRepeat) continue;
    asked.was_sent = true;
    asked.sent_at = now;
    requests.push_back(asked.request);
  }
  return requests;
}

}  // namespace roadbalance
