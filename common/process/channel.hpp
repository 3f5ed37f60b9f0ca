#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

namespace roadbalance {

namespace detail {
template <typename T>
struct ChannelState {
  explicit ChannelState(std::size_t limit) : capacity(limit) {}
  const std::size_t capacity;
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<T> items;
  bool closed = false;
};

template <typename T>
class ChannelEnd {
 public:
  ChannelEnd(ChannelEnd&&) noexcept = default;
  ChannelEnd& operator=(ChannelEnd&& other) noexcept {
    close();
    state_ = std::move(other.state_);
    return *this;
  }
  ~ChannelEnd() { close(); }

 protected:
  explicit ChannelEnd(std::shared_ptr<ChannelState<T>> state) : state_(std::move(state)) {}

  void close() {
    if (!state_) return;
    {
      const std::lock_guard lock(state_->mutex);
      state_->closed = true;
    }
    state_->changed.notify_all();
    state_.reset();
  }

  std::shared_ptr<ChannelState<T>> state_;
};
}  // namespace detail

template <typename T>
class In;
template <typename T>
class Out;

/// A bounded channel between two processes: `first` is written by one, `second` read by the other.
/// Destroying either end closes it, so shutdown travels with the data.
template <typename T>
std::pair<Out<T>, In<T>> make_channel(std::size_t capacity);

/// The writing end.
template <typename T>
class Out : public detail::ChannelEnd<T> {
 public:
  /// Waits for room.  False if the reader is gone: the value was not taken.
  bool send(T value) {
    auto& s = *this->state_;
    std::unique_lock lock(s.mutex);
    s.changed.wait(lock, [&] { return s.closed || s.items.size() < s.capacity; });
    if (s.closed) return false;
    s.items.push_back(std::move(value));
    lock.unlock();
    s.changed.notify_all();
    return true;
  }

  /// Never waits.  False if there is no room or no reader.
  bool try_send(T value) {
    auto& s = *this->state_;
    {
      const std::lock_guard lock(s.mutex);
      if (s.closed || s.items.size() >= s.capacity) return false;
      s.items.push_back(std::move(value));
    }
    s.changed.notify_all();
    return true;
  }

 private:
  using detail::ChannelEnd<T>::ChannelEnd;
  friend std::pair<Out<T>, In<T>> make_channel<T>(std::size_t);
};

/// The reading end.
template <typename T>
class In : public detail::ChannelEnd<T> {
 public:
  /// Waits for a value.  Nothing once the writer is gone and all it wrote was read.
  std::optional<T> receive() {
    auto& s = *this->state_;
    std::unique_lock lock(s.mutex);
    s.changed.wait(lock, [&] { return s.closed || !s.items.empty(); });
    return take(lock);
  }

  /// As receive, but waits no longer than `timeout`.
  template <typename Duration>
  std::optional<T> receive_for(Duration timeout) {
    auto& s = *this->state_;
    std::unique_lock lock(s.mutex);
    s.changed.wait_for(lock, timeout, [&] { return s.closed || !s.items.empty(); });
    return take(lock);
  }

  /// True once the writer is gone and all it wrote was read.
  bool finished() const {
    const std::lock_guard lock(this->state_->mutex);
    return this->state_->closed && this->state_->items.empty();
  }

 private:
  using detail::ChannelEnd<T>::ChannelEnd;
  friend std::pair<Out<T>, In<T>> make_channel<T>(std::size_t);

  std::optional<T> take(std::unique_lock<std::mutex>& lock) {
    auto& s = *this->state_;
    if (s.items.empty()) return std::nullopt;
    std::optional<T> value(std::move(s.items.front()));
    s.items.pop_front();
    lock.unlock();
    s.changed.notify_all();
    return value;
  }
};

template <typename T>
std::pair<Out<T>, In<T>> make_channel(std::size_t capacity) {
  auto state = std::make_shared<detail::ChannelState<T>>(capacity);
  return {Out<T>(state), In<T>(state)};
}

}  // namespace roadbalance
