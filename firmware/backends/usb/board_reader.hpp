#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/frontend/front_end.hpp"
#include "common/types/clocks.hpp"
#include "common/types/device_report.hpp"
#include "common/types/scan.hpp"
#include "firmware/backends/usb/board_clock.hpp"
#include "firmware/backends/usb/board_pair.hpp"
#include "firmware/backends/usb/inbox.hpp"
#include "firmware/backends/usb/packet_stream.hpp"
#include "firmware/backends/usb/scan_flow.hpp"

namespace roadbalance {

/// Numbers a node's scans through all runs of its board: within a run as the board does; over the absence
/// between two by the time that passed.
class ScanNumbering {
 public:
  struct Number {
    std::int64_t index = 0;
    bool after_absence = false;
  };

  /// The board was there (again) and started; its scans count from 0.
  void start_run() noexcept { first_of_run_ = true; }

  /// @param period_s  between the run's scans by the machine's clock; of an absence that of the run before
  /// counts
  Number number(std::int64_t index_in_run, NodeTime time, double period_s) noexcept;

 private:
  bool first_of_run_ = true;
  bool any_ = false;
  std::int64_t offset_ = 0;  ///< what is added to the board's index
  std::int64_t last_index_ = 0;
  NodeTime last_time_{};
  double period_s_ = 0.0;
};

/// Edges until their scans go; edges that do not fit are counted and replaced by a mark.  Never allocates
/// after construction.
class BoardEdges {
 public:
  explicit BoardEdges(DeviceReport& report) : report_(report) {}

  void add(const Edge& edge) noexcept {
    bool& lost = lost_[edge.line];
    if (size_ + 2 > kEdges) {
      if (!lost) report_.count(DeviceCounter::kEdgesLost);
      lost = true;
      return;
    }
    if (lost) push({edge.time, edge.line, EdgeKind::kLost});
    lost = false;
    push(edge);
  }
  const Edge* front() const noexcept { return size_ == 0 ? nullptr : &edge_[begin_ % kEdges]; }
  void drop() noexcept { ++begin_, --size_; }

 private:
  static constexpr std::size_t kEdges = 8192;
  void push(const Edge& edge) noexcept { edge_[(begin_ + size_++) % kEdges] = edge; }

  DeviceReport& report_;
  std::vector<Edge> edge_ = std::vector<Edge>(kEdges);
  std::size_t begin_ = 0, size_ = 0;
  std::array<bool, kEncoderLines> lost_{};
};

/// Packets of a node's boards -> its scans and edges.  Uses no USB.  Never allocates after construction.
class BoardReader {
 public:
  /// @param reports   one for each board, 1 or 2; they outlive this
  /// @param rate_hz   of scans
  /// @param channels  of the node that are used; the others stay 0
  /// @param lines     which of the node's encoders are at the first board
  BoardReader(const std::vector<DeviceReport*>& reports, double rate_hz, std::size_t channels,
              std::array<bool, kEncoderLines> lines);

  void take(const BoardDelivery& delivery) noexcept;

  /// Appends to what is in `read` already; as FrontEnd::read().  False: the spans are full, more is there.
  bool hand_over(std::span<Scan> scans, std::span<Edge> edges, Read& read) noexcept;

  /// False: two boards have lost each other in the run token() and must be started again.
  bool aligned() const noexcept { return pair_.aligned(); }
  std::uint32_t token() const noexcept { return token_; }
  /// For a board, in the run token().
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
  bool edges_missing_ = false;  ///< to be marked before the next packet's content
  bool any_run_ = false;
  BoardPair pair_;
  BoardEdges edges_;
  ScanNumbering numbering_;
};

}  // namespace roadbalance
