#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/frontend/front_end.hpp"
#include "firmware/backends/usb/board_clock.hpp"
#include "firmware/backends/usb/board_edges.hpp"
#include "firmware/backends/usb/board_pair.hpp"
#include "firmware/backends/usb/inbox.hpp"
#include "firmware/backends/usb/packet_stream.hpp"
#include "firmware/backends/usb/scan_flow.hpp"
#include "firmware/backends/usb/scan_numbering.hpp"

namespace roadbalance {

/// What the boards of a node sent -> its scans and edges.  Knows no USB.  Never allocates after construction.
class BoardReader {
 public:
  /// @param reports   one for each board, 1 or 2; they outlive this
  /// @param rate_hz   of scans
  /// @param channels  of the node that are used; the others stay 0
  /// @param lines     which of the node's encoders are at the first board
  BoardReader(const std::vector<DeviceReport*>& reports, double rate_hz, std::size_t channels,
              std::array<bool, kEncoderLines> lines);

  void take(const BoardDelivery& delivery) noexcept;

  /// Appends to what `read` says is there already; as FrontEnd::read().  False: the spans are full, more is
  /// there.
  bool hand_over(std::span<Scan> scans, std::span<Edge> edges, Read& read) noexcept;

  /// False: two boards have lost each other in the run token() and must be started again.
  bool aligned() const noexcept { return pair_.aligned(); }
  std::uint32_t token() const noexcept { return token_; }
  /// Of a board, in the run token().
  const ScanFlow& flow(std::size_t board) const noexcept { return flow_[board]; }

 private:
  void begin_run(const RunBegin& run) noexcept;
  bool take_packet(std::size_t board, const PacketStream::Packet& packet, NodeTime arrival) noexcept;
  void take_edges(const PacketStream::Packet& packet) noexcept;
  void mark_lost(NodeTime time) noexcept;
  Scan scan_of(const BoardPair::Common& common) noexcept;

  const std::vector<DeviceReport*> report_;
  const double rate_hz_;
  const std::size_t channels_;
  const std::array<bool, kEncoderLines> lines_;
  std::vector<PacketStream> stream_;
  std::array<ScanFlow, 2> flow_;
  std::array<std::optional<BoardClock>, 2> clock_;  ///< as many as boards, once a run has begun
  std::uint32_t token_ = 0;
  std::uint32_t ticks_per_scan_ = 0;
  NodeTime last_scan_time_{};   ///< of the first board
  bool edges_missing_ = false;  ///< to be told before the next packet's content
  bool any_run_ = false;
  BoardPair pair_;
  BoardEdges edges_;
  ScanNumbering numbering_;
};

}  // namespace roadbalance
