#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "common/bus/message_socket.hpp"

namespace roadbalance {

/// A thread that empties a socket for somebody who may be busy for longer than it can hold.
class ReadAhead {
 public:
  static constexpr Runs kRuns = Runs::kWhole;  ///< of the socket and of batches

  /// @param most_bytes  that what it holds takes, a page for each datagram at least; what comes beyond them
  /// waits in the
  ///                    socket
  ReadAhead(MessageSocket& socket, std::size_t most_bytes);

  /// Gives what came first for a batch that has been handled, once there is some.  False if there was none
  /// within `timeout`, and the batch is empty.
  /// @throws std::system_error what the socket threw
  bool swap(std::unique_ptr<MessageBatch>& handled, std::chrono::milliseconds timeout);

 private:
  void read(std::stop_token stop);
  bool take_what_came();

  MessageSocket& socket_;
  const std::size_t most_bytes_;
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<std::unique_ptr<MessageBatch>> waiting_;
  std::size_t held_bytes_ = 0;  ///< by those that wait
  std::unique_ptr<MessageBatch> spare_;
  std::exception_ptr failure_;
  std::jthread thread_;  ///< last: it uses the others
};

}  // namespace roadbalance
