#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "common/types/device_report.hpp"
#include "firmware/board/packet.hpp"

namespace roadbalance {

/// The transfers of one board's run -> its packets in order, each at most once; what is missing shows.
///
/// A transfer that is no packet, or whose packet does not go on from those before, is refused and counted.
/// Never allocates.
class PacketStream {
 public:
  struct Packet {
    board::PacketView content;
    bool after_missing = false;  ///< packets before it never came, and their edges neither
  };

  /// @param report  counts what the board suffers; outlives this
  explicit PacketStream(DeviceReport& report) : report_(report) {}

  /// A new run of the board: packets of earlier ones, which may still be on their way, are left aside.
  /// @param begin_ticks  of the board's timer, before the first scan
  void start(std::uint32_t token, std::uint32_t ticks_per_scan, std::uint32_t tick_hz,
             std::uint64_t begin_ticks) noexcept;

  /// @param transfer  refers to the bytes as long as the result lives
  /// @param dropped   packets that this node had no room for since the last call: missing, but not on the way
  std::optional<Packet> take(std::span<const std::uint8_t> transfer, std::uint32_t dropped) noexcept;

  /// The packet that take() returned has a stamp that cannot be: the next one need not come behind it, nor
  /// behind its scans.
  void distrust() noexcept {
    scan_end_ticks_ = edge_end_ticks_ = 0;
    next_scan_ = known_scan_;
  }

 private:
  std::uint64_t most_scans(std::uint64_t ticks) const noexcept;
  bool goes_on(const board::PacketView& packet) const noexcept;
  void count_losses(const board::PacketView& packet) noexcept;

  DeviceReport& report_;
  std::uint32_t token_ = 0;
  std::uint32_t ticks_per_scan_ = 0;
  std::uint32_t tick_hz_ = 0;
  std::uint64_t begin_ticks_ = 0;
  std::uint32_t early_ticks_ = 0;  ///< a scan may be converted so long before its nominal instant
  std::uint32_t sequence_ = 0;     ///< of the next packet
  std::uint64_t next_scan_ = 0;
  std::uint64_t known_scan_ = 0;      ///< next_scan_ before the last packet
  std::uint64_t scan_end_ticks_ = 0;  ///< no scan comes before it, and no edge more than early_ticks_
  std::uint64_t edge_end_ticks_ = 0;  ///< no edge comes before it
  std::uint32_t scans_lost_ = 0;      ///< as the board reported last, with those missed
  std::uint32_t glitches_ = 0;        ///< as the board reported last
  std::uint32_t dropped_ = 0;
};

}  // namespace roadbalance
