#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/types/clocks.hpp"
#include "firmware/board/packet.hpp"
#include "firmware/board/sample_ring.hpp"

namespace roadbalance {

/// A scan as a board converted it.
struct BoardScan {
  std::int64_t index = 0;  ///< in the board's run
  std::uint64_t ticks = 0;
  NodeTime time{};
  board::PacketScan content;
};

/// Puts the scans of a node's boards together by their index: of one board as they come, of two only those
/// that both have.  Their shared start and SYNC make scan n of one scan n of the other.
///
/// That they stayed aligned is proved scan by scan: from one common scan to the next both timers must show
/// the same time, up to their oscillators' difference; a scan too many or too few at either would show as a
/// whole period.  Never allocates after construction.
class BoardPair {
 public:
  /// As much as a board can hold back, twice: when it comes at last the other's have not gone.
  static constexpr std::size_t kScans = 2 * board::SampleRing::kScans;

  /// @param boards  1 or 2
  explicit BoardPair(std::size_t boards);

  /// A shared start.
  /// @param tick_hz  of each board's timer
  void start(std::array<std::uint32_t, 2> tick_hz, double rate_hz) noexcept;

  /// Scans of one board come in order.
  /// @return false if this one is kScans ahead of the other, so that its oldest went
  [[nodiscard]] bool add(std::size_t board, const BoardScan& scan) noexcept;

  /// The next common scan; nullptr: none yet.  It stays until drop().
  struct Common {
    const BoardScan* first = nullptr;
    const BoardScan* second = nullptr;  ///< nullptr of one board
  };
  Common front() noexcept;
  void drop() noexcept;

  /// False: the boards have slipped; their packets do not belong together until they start again.
  bool aligned() const noexcept { return aligned_; }

 private:
  struct Queue {
    std::vector<BoardScan> scan = std::vector<BoardScan>(kScans);
    std::size_t begin = 0, size = 0;
    const BoardScan& front() const { return scan[begin % kScans]; }
    void pop() { ++begin, --size; }
  };
  bool keeps_step(const BoardScan& first, const BoardScan& second) const noexcept;

  std::vector<Queue> queue_;
  std::array<double, 2> tick_s_{};
  double tolerance_s_ = 0.0;
  bool aligned_ = true;
  bool proved_ = false;                   ///< a common scan has been
  std::array<std::uint64_t, 2> ticks_{};  ///< of the last one
};

}  // namespace roadbalance
