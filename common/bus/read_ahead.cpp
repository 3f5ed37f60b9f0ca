#include "common/bus/read_ahead.hpp"

#include <utility>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kLook{100};     // at whether it is to end
constexpr milliseconds kFullAgain{5};  // and no room: the socket holds what comes

}  // namespace

ReadAhead::ReadAhead(MessageSocket& socket, std::size_t most_bytes)
    : socket_(socket), most_bytes_(most_bytes), thread_([this](std::stop_token stop) { read(stop); }) {}

bool ReadAhead::swap(std::unique_ptr<MessageBatch>& handled, milliseconds timeout) {
  handled->clear();
  std::unique_lock lock(mutex_);
  came_.wait_for(lock, timeout, [this] { return !waiting_.empty() || failure_; });
  if (waiting_.empty()) {
    if (failure_) std::rethrow_exception(failure_);
    return false;
  }
  spare_ = std::exchange(handled, std::move(waiting_.front()));
  waiting_.pop_front();
  held_bytes_ -= handled->held_bytes();
  return true;
}

void ReadAhead::read(std::stop_token stop) {
  try {
    while (!stop.stop_requested())
      if (socket_.wait(kLook) && !take_what_came()) std::this_thread::sleep_for(kFullAgain);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
  }
  came_.notify_one();
}

/// False if there is no room for it.
bool ReadAhead::take_what_came() {
  const std::lock_guard lock(mutex_);
  if (held_bytes_ >= most_bytes_) return false;
  if (waiting_.empty() || waiting_.back()->full())
    waiting_.push_back(spare_ ? std::move(spare_) : std::make_unique<MessageBatch>(kRuns));
  MessageBatch& last = *waiting_.back();
  held_bytes_ -= last.held_bytes();
  (void)socket_.receive(last);
  held_bytes_ += last.held_bytes();
  came_.notify_one();
  return true;
}

}  // namespace roadbalance
