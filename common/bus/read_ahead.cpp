#include "common/bus/read_ahead.hpp"

#include <algorithm>
#include <utility>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kLook{100};     // at whether it is to end
constexpr milliseconds kFullAgain{5};  // and no room: the socket holds what comes

}  // namespace

ReadAhead::ReadAhead(MessageSocket& socket, std::size_t most_bytes)
    : socket_(socket),
      most_batches_(std::max<std::size_t>(1, most_bytes / sizeof(MessageBatch))),
      thread_([this](std::stop_token stop) { read(stop); }) {}

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
  if (waiting_.empty() || waiting_.back()->full()) {
    if (waiting_.size() >= most_batches_) return false;
    waiting_.push_back(spare_ ? std::move(spare_) : std::make_unique<MessageBatch>());
  }
  (void)socket_.receive(*waiting_.back());
  came_.notify_one();
  return true;
}

}  // namespace roadbalance
