#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/frontend/dropped_edges.hpp"
#include "common/link/blocks.hpp"
#include "firmware/block_sink.hpp"
#include "firmware/device_silence.hpp"
#include "firmware/preview_slot.hpp"
#include "firmware/reference.hpp"

namespace roadbalance {

/// Scans and edges -> sealed blocks of one epoch, numbered without gaps from 1.
///
/// Order: the vehicle's description (meta), then scan, edge and gap blocks, at last the end.  Scan blocks and
/// gaps tile the scans [0, end) of the epoch.  A scan block waits for the edges its references need, at most
/// 100 ms of node time; then it goes without and says so.  Scans that the device lost, or for which the sink
/// has no room, become gaps with exact range and cause; of a full sink one gap that grows.  A device that is
/// not there at the start or at the stop has no scan to tell how many it lost: that is the time without,
/// times the rate, kDeviceGone (asked()).
///
/// Edges and signals are recorded as they came: signals within 0.2 s; edges too, but of slow wheels once
/// there are 350, or after 1 s.  A full sink is waited for with one block of each; what comes when that is
/// full too is lost within the gap, which grows to the first scan behind it and, where no scan is left, may
/// cover none. The first edge of a line behind lost ones follows a mark of kLost.  Only what a device tells
/// later than the scans of its instant may lie before the gap in which it is lost, by as much.
///
/// Until start() and after stop() scan blocks have sequence 0 and go to the preview slot only.
/// Never allocates after construction.
class Sealer {
 public:
  /// @param preview  may be nullptr
  /// @param jump     cause of a jump in the device's scan index unless the device was absent
  Sealer(const VehicleConfig& vehicle, const NodeConfig& node, std::int64_t epoch, BlockSink& sink,
         PreviewSlot* preview, GapCause jump = GapCause::kDeviceOverrun);

  /// Scans from the next one added on are kept.  Once; later calls do nothing.
  void start() noexcept;
  /// Scans from the next one added on are not.  Once; the end is sealed when the last kept scan is.
  void stop() noexcept;

  /// What one read of a front end returned.
  /// @param more_edges  some that were stamped before the last scan come later
  void add(std::span<const Scan> scans, std::span<const Edge> edges, bool more_edges) noexcept;
  /// Signal samples that came with it; before its scans, whose angles may need them.
  void add(std::span<const SignalSample> signals) noexcept;
  /// A read of a device that runs by the clock has returned, with what was added since the last call, at
  /// `now` by the device's clock.  Of a device that waits for its reader: never.
  void asked(NodeTime now) noexcept;
  /// The device has no more: seals all there is, and the end.
  void device_ended() noexcept;

  /// Writes the end as soon as the sink takes it.  True once it is written: nothing follows.
  bool finish() noexcept;

  bool started() const noexcept { return keep_from_ != kNever; }
  bool ended() const noexcept { return ended_; }
  NodeTime time() const noexcept { return now_; }

  struct Counts {
    std::int64_t scans_sampled = 0;        ///< kept or declared missing
    std::int64_t scans_missing = 0;        ///< of these, in gaps
    std::int64_t scans_refused = 0;        ///< numbered before an earlier one, or beyond kIndexLimit
    std::int64_t unreferenced_blocks = 0;  ///< kept without the angle of a wheel that has an encoder
  };
  const Counts& counts() const noexcept { return counts_; }
  EncoderFaults encoder_faults(int line) const noexcept { return reference_.faults(line); }

  /// Blocks that adding so many scans, edges and samples can write at most, with what is waiting and the end.
  std::size_t most_blocks(std::size_t scans, std::size_t edges, std::size_t signals = 0) const noexcept;

  static constexpr std::int64_t kLongestWait_ns = 100'000'000;

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  struct Run {
    int scans = 0;
    bool whole = false;  ///< nothing can be added to it
  };
  const Scan& at(std::int64_t position) const noexcept {
    return waiting_[static_cast<std::size_t>(position) % waiting_.size()];
  }
  void push(const Scan& scan) noexcept;
  Run next_run() const noexcept;
  bool seal_next(NodeTime edges_through, bool at_once) noexcept;
  void build(int scans) noexcept;
  void keep_block(bool after_jump) noexcept;
  void preview_block() noexcept;
  void record(const Edge& edge) noexcept;
  template <typename Item, typename Block>
  bool place(const Item& item, Block& block) noexcept;
  template <typename Block>
  bool write_beside(Block& block) noexcept;
  bool write_what_comes_before() noexcept;
  void lose_beside(NodeTime time) noexcept;
  bool write_metas() noexcept;
  std::int64_t scans_between(std::int64_t from_ns, std::int64_t to_ns) const noexcept;
  void count_from(const Scan& first_kept) noexcept;
  void declare_jump(std::int64_t scans, std::int64_t time_ns) noexcept;
  bool declare_last_silence() noexcept;
  void lose(std::int64_t first_scan, std::int64_t scans, std::int64_t time_ns, GapCause cause) noexcept;
  bool close_gap() noexcept;
  template <typename Block>
  bool write(Block& block) noexcept {
    SealedBlock* const room = sink_.claim();
    if (!room) return false;
    block.header.sequence = next_sequence_;
    seal(block, *room);
    sum_.add(*room);
    sink_.commit();
    ++next_sequence_;
    return true;
  }
  BlockHeader header(std::int64_t first_scan, std::int64_t scans, std::int64_t time_ns) const noexcept {
    return {node_, epoch_, next_sequence_, first_scan, scans, time_ns};
  }

  const int node_;
  const std::int64_t epoch_;
  const std::int64_t period_ps_;
  const GapCause jump_cause_;
  const bool loop_back_;
  BlockSink& sink_;
  PreviewSlot* const preview_;
  Reference reference_;
  std::vector<MetaBlock> meta_;
  std::size_t metas_written_ = 0;

  // Scans not yet sealed, by position: how many came before since construction.
  std::vector<Scan> waiting_;
  std::int64_t head_ = 0, tail_ = 0;
  std::int64_t next_attempt_ = 0;  ///< at the angles of scans whose angles were not known
  std::int64_t jumps_ = 0;         ///< index jumps among the waiting scans
  std::int64_t next_index_ = -1;   ///< device index after the last scan added
  std::int64_t keep_from_ = kNever, keep_to_ = kNever;
  NodeTime now_{};
  DeviceSilence silence_;
  std::int64_t asked_tail_ = 0;            ///< tail_ when the device was asked last
  std::optional<NodeTime> started_;        ///< by the device's clock
  std::optional<NodeTime> silent_at_end_;  ///< until then, and not yet declared

  ScanBlock scan_block_;
  EdgeBlock edge_block_;
  SignalBlock signal_block_;
  DroppedEdges dropped_;
  std::optional<GapBlock> gap_;     ///< of a full sink, growing
  NodeTime lost_through_{};         ///< latest stamp of an edge or sample for which there was no room
  std::int64_t sealed_index_ = -1;  ///< device index after the last scan sealed
  /// Device index that the epoch counts from, once a scan is kept: that one's, or before it by what is
  /// missing since the start.
  std::optional<std::int64_t> first_index_;
  std::int64_t next_scan_ = 0;    ///< of the epoch, after the last one kept or declared
  std::int64_t kept_end_ns_ = 0;  ///< one period after the last one kept or lost
  bool after_gap_ = false;
  bool ended_ = false;
  std::int64_t next_sequence_ = 1;
  BlockSum sum_;  ///< of all blocks before next_sequence_
  Counts counts_;
};

}  // namespace roadbalance
