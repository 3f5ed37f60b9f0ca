#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/process/waking_queue.hpp"
#include "firmware/backends/usb/board_clock.hpp"
#include "firmware/board/packet.hpp"

namespace roadbalance {

/// A run of a node's boards begins.
struct RunBegin {
  std::uint32_t token = 0;
  std::array<std::uint32_t, 2> ticks_per_scan{};
  std::array<std::uint32_t, 2> tick_hz{};
  std::array<BoardInstant, 2> begin{};  ///< of each board, from an exchange just before the run
};

/// The thread that serves the boards hands over the beginning of a run, a transfer as it came, or the time
/// that the board reported.
struct BoardDelivery {
  enum class Kind : std::uint8_t { kRunBegin, kTransfer, kExchange };
  Kind kind = Kind::kTransfer;
  std::uint8_t board = 0;
  std::uint32_t dropped = 0;  ///< transfers of this board before this one for which there was no room
  NodeTime arrival{};
  RunBegin run;
  BoardExchange exchange;
  std::uint32_t size = 0;
  std::array<std::uint8_t, board::kTransferBytes> bytes{};
};

/// From the thread that serves the boards to the one that reads scans.
class Inbox : public WakingQueue<BoardDelivery> {
 public:
  Inbox() : WakingQueue(kDeliveries) {}

 private:
  /// At the board's 5 ms a packet more than a second's.
  static constexpr std::size_t kDeliveries = 256;
};

}  // namespace roadbalance
