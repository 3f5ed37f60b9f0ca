#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "common/bus/message_socket.hpp"

namespace roadbalance {

/// Copies of messages, one behind the other.
class HeldMessages : public Messages {
 public:
  static constexpr std::size_t kRoom = 256 << 10;  ///< bytes

  HeldMessages() = default;
  HeldMessages(const HeldMessages&) = delete;
  HeldMessages& operator=(const HeldMessages&) = delete;

  /// False if there is no room for it.
  bool add(const Message& message);
  void clear() {
    Messages::clear();
    used_ = 0;
  }

 private:
  std::unique_ptr<std::uint8_t[]> room_ = std::make_unique_for_overwrite<std::uint8_t[]>(kRoom);
  std::size_t used_ = 0;
};

/// A thread that empties a socket for somebody who may be busy for longer than it can hold.
class ReadAhead {
 public:
  /// @param most_bytes  that it holds, and what one call brings; what comes beyond them waits in the socket
  ReadAhead(MessageSocket& socket, std::size_t most_bytes);

  /// Gives what came first for what has been handled, once there is some.  False if there was none within
  /// `timeout`, and `handled` is empty.
  /// @throws std::system_error what the socket threw
  bool swap(std::unique_ptr<HeldMessages>& handled, std::chrono::milliseconds timeout);

 private:
  void read(std::stop_token stop);
  bool has_room();
  void hold(MessageBatch& came);

  MessageSocket& socket_;
  const std::size_t most_bytes_;
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<std::unique_ptr<HeldMessages>> waiting_;
  std::unique_ptr<HeldMessages> spare_;
  std::exception_ptr failure_;
  std::jthread thread_;  ///< last: it uses the others
};

}  // namespace roadbalance
