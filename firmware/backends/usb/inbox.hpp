#pragma once

#include <semaphore.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <memory>

#include "firmware/backends/usb/board_clock.hpp"
#include "firmware/board/interrupt_ring.hpp"
#include "firmware/board/packet.hpp"

namespace roadbalance {

/// A run of a node's boards begins.
struct RunBegin {
  std::uint32_t token = 0;
  std::array<std::uint32_t, 2> ticks_per_scan{};
  std::array<std::uint32_t, 2> tick_hz{};
  std::array<BoardInstant, 2> begin{};  ///< of each board, from an exchange just before the run
};

/// What the thread that serves the boards hands over: the beginning of a run, or a transfer as it came.
struct BoardDelivery {
  enum class Kind : std::uint8_t { kRunBegin, kTransfer };
  Kind kind = Kind::kTransfer;
  std::uint8_t board = 0;
  std::uint32_t dropped = 0;  ///< transfers of this board before this one for which there was no room
  NodeTime arrival{};
  RunBegin run;
  std::uint32_t size = 0;
  std::array<std::uint8_t, board::kTransferBytes> bytes{};
};

/// From the thread that serves the boards to the one that reads scans: bounded, without locks.
class Inbox {
 public:
  Inbox() { ::sem_init(&filled_, 0, 0); }
  Inbox(const Inbox&) = delete;
  Inbox& operator=(const Inbox&) = delete;
  ~Inbox() { ::sem_destroy(&filled_); }

  /// Writer: room for the next one; nullptr: none.  It is handed over by post().
  BoardDelivery* room() { return ring_->room(); }
  void post() {
    ring_->publish();
    ::sem_post(&filled_);
  }

  /// Reader: the oldest; nullptr: nothing has come.  It stays until drop().
  const BoardDelivery* front() const { return ring_->size() == 0 ? nullptr : &(*ring_)[0]; }
  void drop() {
    ring_->drop(1);
    ::sem_trywait(&filled_);  // its call, unless post() has not come to that yet
  }
  /// Reader: waits until something is there, or until CLOCK_MONOTONIC says `until`.  False: nothing came.
  bool wait(const timespec& until) {
    // A call can be one of something that was dropped before it came: the ring alone says what there is.
    while (!front())
      if (::sem_clockwait(&filled_, CLOCK_MONOTONIC, &until) != 0) return front() != nullptr;
    return true;
  }

 private:
  /// At the board's 5 ms a packet more than a second's.
  static constexpr std::size_t kDeliveries = 256;
  std::unique_ptr<board::InterruptRing<BoardDelivery, kDeliveries>> ring_ =
      std::make_unique<board::InterruptRing<BoardDelivery, kDeliveries>>();
  sem_t filled_;
};

}  // namespace roadbalance
