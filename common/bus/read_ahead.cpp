#include "common/bus/read_ahead.hpp"

#include <cstring>
#include <utility>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kLook{100};     // at whether it is to end
constexpr milliseconds kFullAgain{5};  // and no room: the socket holds what comes

}  // namespace

bool HeldMessages::add(const Message& message) {
  const std::size_t name = message.channel.size(), size = name + message.bytes.size();
  if (used_ + size > kRoom || messages_.size() == kRoom / sizeof(Message)) return false;
  std::uint8_t* const to = &room_[used_];
  std::memcpy(to, message.channel.data(), name);
  if (!message.bytes.empty()) std::memcpy(to + name, message.bytes.data(), message.bytes.size());
  messages_.push_back({{reinterpret_cast<const char*>(to), name}, {to + name, message.bytes.size()}});
  used_ += size;
  return true;
}

ReadAhead::ReadAhead(MessageSocket& socket, std::size_t most_bytes)
    : socket_(socket), most_bytes_(most_bytes), thread_([this](std::stop_token stop) { read(stop); }) {}

bool ReadAhead::swap(std::unique_ptr<HeldMessages>& handled, milliseconds timeout) {
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
    MessageBatch came(socket_.runs());
    while (!stop.stop_requested()) {
      if (!socket_.wait(kLook)) continue;
      if (has_room()) {
        came.clear();
        (void)socket_.receive(came);
        hold(came);
      } else {
        std::this_thread::sleep_for(kFullAgain);
      }
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
  }
  came_.notify_one();
}

bool ReadAhead::has_room() {
  const std::lock_guard lock(mutex_);
  return waiting_.size() * HeldMessages::kRoom < most_bytes_;
}

void ReadAhead::hold(MessageBatch& came) {
  if (came.empty()) return;
  const std::lock_guard lock(mutex_);
  while (!came.empty()) {
    const Message message = came.take();
    if (!waiting_.empty() && waiting_.back()->add(message)) continue;
    waiting_.push_back(spare_ ? std::move(spare_) : std::make_unique<HeldMessages>());
    (void)waiting_.back()->add(message);  // no message is larger
  }
  came_.notify_one();
}

}  // namespace roadbalance
