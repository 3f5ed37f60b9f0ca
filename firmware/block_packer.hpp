#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "common/config/vehicle_config.hpp"
#include "common/types/blocks.hpp"
#include "firmware/block_sink.hpp"
#include "firmware/block_writer.hpp"
#include "firmware/epoch_tiling.hpp"
#include "firmware/preview_slot.hpp"
#include "firmware/reference.hpp"
#include "firmware/side_blocks.hpp"
#include "firmware/waiting_scans.hpp"

namespace roadbalance {

/// Scans and edges -> sealed blocks of one epoch, numbered without gaps from 1.
///
///     scans ──▶ WaitingScans ──▶ scan blocks ──▶ EpochTiling ─┐ gaps
///     edges ──▶ Reference ──────────┘                         ├─▶ BlockWriter ──▶ sink
///     edges, signals ──▶ SideBlocks ──────────────────────────┘
///
/// Order: the vehicle's description (meta), then scan, edge and gap blocks, at last the end.  Scan blocks and
/// gaps tile the scans [0, end) of the epoch.  A scan block waits for the edges its references need, at most
/// 100 ms of node time; then it goes without them and is flagged.  Scans that the device lost, or for which
/// the sink has no room, become gaps with exact range and cause; a full sink makes one gap that grows.  A
/// device that is absent at the start or at the stop has no scan that shows how many it lost: that is the
/// time without it, times the rate, kDeviceGone (asked()).
///
/// Edges and signals are recorded as they came (SideBlocks).  An edge or sample that finds no room is lost
/// within a gap, which grows to the first scan behind it and, where no scan is left, may cover none.  Only
/// one that a device reports later than the scans of its instant may lie before the gap in which it is lost,
/// by as much.
///
/// Until start() and after stop() scan blocks have sequence 0 and go to the preview slot only.
/// Never allocates after construction.
class BlockPacker {
 public:
  /// @param preview  may be nullptr
  /// @param jump     cause of a jump in the device's scan index unless the device was absent
  BlockPacker(const VehicleConfig& vehicle, const NodeConfig& node, std::int64_t epoch, BlockSink& sink,
              PreviewSlot* preview, GapCause jump = GapCause::kDeviceOverrun);
  BlockPacker(const BlockPacker&) = delete;
  BlockPacker& operator=(const BlockPacker&) = delete;

  /// Scans of `from` on are kept, by the device's clock.  A later call corrects the instant, until it has
  /// come. Scans that were added before the call are not: those behind the instant are missing, kStartedLate.
  void start(NodeTime from = NodeTime::min()) noexcept;
  /// Scans of `to` on are not, but for those added before the call.  As start(); the end is sealed when the
  /// last kept scan is.
  void stop(NodeTime to = NodeTime::min()) noexcept;

  /// The result of one read of a front end.
  /// @param more_edges  some that were stamped before the last scan come later
  void add(std::span<const Scan> scans, std::span<const Edge> edges, bool more_edges) noexcept;
  /// Signal samples that came with it; before its scans, whose angles may need them.
  void add(std::span<const SignalSample> signals) noexcept;
  /// A read of a device that runs by the clock has returned, with what was added since the last call, at
  /// `now` by the device's clock.  Never called for a device that waits for its reader.
  void asked(NodeTime now) noexcept;
  /// EpochTiling::begin_at(), before the first scan, and end_at(), before device_ended().
  void begin_at(std::int64_t index, NodeTime time) noexcept { tiling_.begin_at(index, time); }
  void end_at(std::int64_t index, NodeTime time) noexcept { tiling_.end_at(index, time); }
  /// The device has no more: seals all there is, and the end.
  void device_ended() noexcept;

  /// Writes the end as soon as the sink takes it.  True once it is written: nothing follows.
  bool finish() noexcept;

  /// Its instant has come.
  bool started() const noexcept { return started_; }
  bool ended() const noexcept { return ended_; }
  /// Time of the last scan added.
  NodeTime time() const noexcept { return waiting_.latest(); }

  struct Counts {
    std::int64_t scans_sampled = 0;        ///< kept or declared missing
    std::int64_t scans_missing = 0;        ///< of these, in gaps
    std::int64_t scans_refused = 0;        ///< numbered before an earlier one, or beyond kIndexLimit
    std::int64_t unreferenced_blocks = 0;  ///< kept without the angle of a wheel that has an encoder
  };
  Counts counts() const noexcept {
    return {tiling_.scans_sampled(), tiling_.scans_missing(), scans_refused_, unreferenced_blocks_};
  }
  EncoderFaults encoder_faults(int line) const noexcept { return reference_.faults(line); }

  /// Blocks that adding so many scans, edges and samples can write at most, with what is waiting and the end.
  std::size_t most_blocks(std::size_t scans, std::size_t edges, std::size_t signals = 0) const noexcept;

  static constexpr std::int64_t kLongestWait_ns = 100'000'000;

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  void begin(bool is_late) noexcept;
  void end() noexcept;
  bool keeps_beside(NodeTime stamped) noexcept;
  bool seal_next(NodeTime edges_through, bool at_once) noexcept;
  void build(int scans) noexcept;
  void keep_block() noexcept;
  void preview_block() noexcept;
  bool write_what_comes_before() noexcept;

  const std::int64_t period_ps_;
  const bool loop_back_;
  PreviewSlot* const preview_;
  Reference reference_;
  BlockWriter writer_;
  WaitingScans waiting_;
  EpochTiling tiling_;
  SideBlocks beside_;

  NodeTime start_at_ = NodeTime::max(), stop_at_ = NodeTime::max();
  bool started_ = false;
  std::int64_t keep_from_ = kNever, keep_to_ = kNever;  ///< positions of waiting_
  std::int64_t next_attempt_ = 0;  ///< at the angles of scans whose angles were not known
  ScanBlock scan_block_;
  bool after_gap_ = false;
  bool ended_ = false;
  std::int64_t scans_refused_ = 0;
  std::int64_t unreferenced_blocks_ = 0;
};

}  // namespace roadbalance
