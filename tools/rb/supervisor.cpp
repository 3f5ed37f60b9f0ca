#include "tools/rb/supervisor.hpp"

#include <algorithm>
#include <cassert>

namespace roadbalance {
namespace {

constexpr int kUsageCode = 2;
constexpr int kIncompleteCode = 3;  // it has ended in order, and samples are missing
constexpr std::chrono::milliseconds kIdle{1000};

}  // namespace

Supervisor::Act Supervisor::due(WallTime now) {
  if (over_) return Act::kNone;
  if (state_ == State::kWaiting) return now >= start_at_ ? Act::kStart : Act::kNone;
  if (state_ == State::kKilled || !options_.watchdog || now < hangs_at()) return Act::kNone;
  state_ = State::kKilled;
  return Act::kKill;
}

WallTime Supervisor::hangs_at() const {
  if (fed_) return fed_at_ + *options_.watchdog;
  return started_at_ + std::max(options_.start_limit, *options_.watchdog);
}

std::chrono::milliseconds Supervisor::time_left(WallTime now) const {
  using std::chrono::milliseconds;
  const auto until = [now](WallTime at) {
    return std::max(milliseconds(0), std::chrono::ceil<milliseconds>(at - now));
  };
  if (state_ == State::kWaiting) return until(start_at_);
  return state_ == State::kRunning && options_.watchdog ? std::min(kIdle, until(hangs_at())) : kIdle;
}

void Supervisor::started(WallTime now) {
  assert(state_ == State::kWaiting);
  state_ = State::kRunning;
  started_at_ = now;
  fed_ = false;
}

void Supervisor::take(std::string_view message, WallTime now) {
  while (!message.empty()) {
    const auto line = message.substr(0, message.find('\n'));
    message.remove_prefix(std::min(message.size(), line.size() + 1));
    if (line == "WATCHDOG=1" || line == "READY=1") {
      fed_ = true;
      fed_at_ = now;
    }
    if (line.starts_with("STATUS=")) status_ = line.substr(7);
  }
}

void Supervisor::ended(int code, WallTime now) {
  if (code == 0 || code == kUsageCode || code == kIncompleteCode || code == kCannotExecute || stopping_) {
    over_ = code;
    return;
  }
  state_ = State::kWaiting;
  if (now - started_at_ >= options_.good_run) wait_ = std::chrono::milliseconds(0);
  start_at_ = now + wait_;
  wait_ = std::clamp(2 * wait_, options_.first_wait, options_.longest_wait);
  ++restarts_;
}

}  // namespace roadbalance
