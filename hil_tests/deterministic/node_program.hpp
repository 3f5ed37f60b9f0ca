#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>

#include "common/bus/codec.hpp"
#include "common/frontend/front_end.hpp"
#include "common/link/backlog.hpp"
#include "firmware/block_packer.hpp"
#include "firmware/node_link.hpp"
#include "firmware/ring_sink.hpp"
#include "firmware/sleep_gaps.hpp"
#include "firmware/spool_folder.hpp"
#include "hil_tests/deterministic/beside_check.hpp"
#include "hil_tests/deterministic/node_machine.hpp"

namespace roadbalance::test {

/// The ring as the packer sees it, with a witness.
class WitnessedSink final : public BlockSink {
 public:
  WitnessedSink(Ring& ring, Truth& truth, EpochTruth& epoch, BesideCheck& beside)
      : sink_(ring), truth_(truth), epoch_(epoch), beside_(beside) {}
  std::size_t room() const noexcept override { return sink_.room(); }
  SealedBlock* claim() noexcept override { return block_ = sink_.claim(); }
  void commit() noexcept override {
    truth_.sealed(epoch_, *block_, now_ns);
    if (block_->kind == BlockKind::kGap) {
      const GapBlock gap = decode_gap(*block_);
      if (gap.cause == GapCause::kSlept) slept_scans += gap.header.scans;
      if (gap.cause == GapCause::kRingFull) was_full = true;
    }
    beside_.sealed(*block_);
    sink_.commit();
  }
  std::int64_t now_ns = 0;
  std::int64_t slept_scans = 0;
  bool was_full = false;  // a gap may have taken others into itself

 private:
  RingSink sink_;
  Truth& truth_;
  EpochTruth& epoch_;
  BesideCheck& beside_;
  SealedBlock* block_ = nullptr;
};

/// A front end that gives what was put into it.
class HandedOver final : public FrontEnd {
 public:
  std::span<const Scan> scans;
  Read read(std::span<Scan> to, std::span<Edge>, std::span<SignalSample>) noexcept override {
    std::ranges::copy(scans, to.begin());
    return {.scans = scans.size()};
  }
};

/// One run of a node: from its start to its end or death.
struct NodeMachine::Program {
  Program(const FaultScenario& scenario, const VehicleConfig& vehicle, std::int32_t node, EpochTruth& of,
          Truth& all, VehicleChange& change, Disk& disk, const std::int64_t& machine_slept_ns);

  EpochTruth& truth;
  BesideCheck beside;
  Ring ring;
  WitnessedSink sink;
  PreviewSlot preview;
  AcquireLink link;
  BlockPacker packer;
  std::unique_ptr<SpoolFolder> spool;
  Backlog backlog;
  NodeLink uplink;
  HashedScans samples;
  std::int64_t next_index = 0;                            // of the device
  NodeTime from = NodeTime::max(), to = NodeTime::max();  // it is kept, by its clock; max: nobody has asked
  NodeTime latest = NodeTime::min();                      // of a scan given
  bool is_late = false, has_first = false;
  std::int64_t first_index = 0;  // of number 0 in the epoch
  std::int64_t started_ns = 0;   // the device's index 0
  std::int64_t slept_ns = 0;     // of its computer since then
  std::int64_t slept_between_scans_ns = 0;
  std::int64_t skipped = 0;       // numbers of scans that it would have taken in that time
  std::int64_t skipped_kept = 0;  // of these, in the epoch
  bool wakes = false;             // behind its latest scan it has slept
  HandedOver handed;
  SleepGaps sleeps;
  AbsenceCause ends = AbsenceCause::kNone;  // other than by the command of its recorder
  bool stopped = false;
  std::int64_t highest_owner = 0;
};

}  // namespace roadbalance::test
