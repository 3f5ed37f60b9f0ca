#include "firmware/backends/usb/packet_stream.hpp"

#include <algorithm>
#include <utility>

#include "firmware/board/byte_order.hpp"

namespace roadbalance {
namespace {

using board::PacketFault;
using board::PacketHeader;

/// A scan is converted within 0.5 us of the instant in its packet.
constexpr std::uint32_t kEarlyPerSecond = 2'000'000;
/// A count that fell: the packet is an old one.
constexpr std::uint32_t kBackwards = 1u << 31;

/// Whether a transfer of wrong length ended before the length in its header.
bool ended_early(std::span<const std::uint8_t> transfer) {
  if (transfer.size() < board::packet_bytes(0, 0)) return true;
  constexpr std::size_t kScansAt = 36;
  board::ByteReader in(transfer.subspan(kScansAt));
  const std::size_t scans = in.take<std::uint16_t>();
  const std::size_t edges = in.take<std::uint16_t>();
  return transfer.size() < board::packet_bytes(scans, edges);
}

std::uint64_t edge_ticks(const board::PacketView& packet, std::size_t k) {
  return packet.header().base_ticks + static_cast<std::uint64_t>(std::int64_t{packet.edge(k).offset_ticks});
}

DeviceCounter counter_of(PacketFault fault, std::span<const std::uint8_t> transfer) {
  const bool is_short = fault == PacketFault::kLength && ended_early(transfer);
  return is_short ? DeviceCounter::kShortPackets : DeviceCounter::kPacketsRefused;
}

}  // namespace

void PacketStream::start(std::uint32_t token, std::uint32_t ticks_per_scan, std::uint32_t tick_hz,
                         std::uint64_t begin_ticks) noexcept {
  token_ = token;
  begin_ticks_ = begin_ticks;
  tick_hz_ = tick_hz;
  ticks_per_scan_ = ticks_per_scan;
  early_ticks_ = tick_hz / kEarlyPerSecond;
  sequence_ = 0;
  next_scan_ = known_scan_ = 0;
  scan_end_ticks_ = 0;
  edge_end_ticks_ = 0;
  scans_lost_ = 0;
  glitches_ = 0;
  dropped_ = 0;
}

// A board counts its scans with the timer that stamps them.  The stamp may be what is wrong, by as much as
// goes unnoticed: a second.
std::uint64_t PacketStream::most_scans(std::uint64_t ticks) const noexcept {
  const auto passed = std::max<std::int64_t>(static_cast<std::int64_t>(ticks - begin_ticks_), 0);
  return (static_cast<std::uint64_t>(passed) + tick_hz_) / ticks_per_scan_;
}

bool PacketStream::goes_on(const board::PacketView& packet) const noexcept {
  const PacketHeader& header = packet.header();
  const std::uint64_t edges_begin =
      std::max(scan_end_ticks_ - std::min<std::uint64_t>(scan_end_ticks_, early_ticks_), edge_end_ticks_);
  if (header.edges > 0 && edge_ticks(packet, 0) < edges_begin) return false;
  return header.sequence - sequence_ < kBackwards && header.first_scan >= next_scan_ &&
         header.ticks_per_scan == ticks_per_scan_ && header.first_scan <= most_scans(header.base_ticks) &&
         (header.scans == 0 || header.base_ticks >= scan_end_ticks_);
}

std::optional<PacketStream::Packet> PacketStream::take(std::span<const std::uint8_t> transfer,
                                                       std::uint32_t dropped) noexcept {
  dropped_ += dropped;
  if (transfer.empty()) return std::nullopt;  // ends a packet of whole USB packets
  PacketFault fault{};
  const auto packet = board::decode_packet(transfer, &fault);
  if (!packet) {
    report_.count(counter_of(fault, transfer));
    return std::nullopt;
  }
  const PacketHeader& header = packet->header();
  if (header.token != token_) return std::nullopt;
  if (!goes_on(*packet)) {
    report_.count(DeviceCounter::kPacketsRefused);
    return std::nullopt;
  }
  const std::uint32_t missing = header.sequence - sequence_;
  if (missing > dropped_) report_.count(DeviceCounter::kPacketsMissing, missing - dropped_);
  count_losses(*packet);
  dropped_ = 0;
  sequence_ = header.sequence + 1;
  known_scan_ = std::exchange(next_scan_, header.first_scan + header.scans);
  if (header.edges > 0) edge_end_ticks_ = edge_ticks(*packet, header.edges - std::size_t{1});
  if (header.scans > 0)
    scan_end_ticks_ = header.base_ticks + (header.scans - std::uint64_t{1}) * ticks_per_scan_ + 1;
  return Packet{*packet, missing > 0};
}

void PacketStream::count_losses(const board::PacketView& packet) noexcept {
  const std::uint32_t scans_lost = packet.header().scans_lost + packet.header().scans_missed;
  if (scans_lost != scans_lost_) report_.count(DeviceCounter::kBoardOverrun, scans_lost - scans_lost_);
  scans_lost_ = scans_lost;
  const std::uint32_t glitches = packet.header().glitches;
  if (glitches != glitches_) report_.count(DeviceCounter::kGlitches, glitches - glitches_);
  glitches_ = glitches;
  if (!(packet.header().flags & board::kEdgesLostHere)) return;
  for (std::size_t k = 0; k < packet.header().edges; ++k)
    if (packet.edge(k).kind == board::PacketEdgeKind::kLost) report_.count(DeviceCounter::kEdgesLost);
}

}  // namespace roadbalance
