#pragma once

#include <cstdint>
#include <memory>

#include "common/link/backlog.hpp"
#include "firmware/block_packer.hpp"
#include "firmware/node_link.hpp"
#include "firmware/ring_sink.hpp"
#include "firmware/spool_folder.hpp"
#include "hil_tests/deterministic/beside_check.hpp"
#include "hil_tests/deterministic/node_machine.hpp"

namespace roadbalance::test {

/// The ring as the sealer sees it, with a witness.
class WitnessedSink final : public BlockSink {
 public:
  WitnessedSink(Ring& ring, Truth& truth, EpochTruth& epoch, BesideCheck& beside)
      : sink_(ring), truth_(truth), epoch_(epoch), beside_(beside) {}
  std::size_t room() const noexcept override { return sink_.room(); }
  SealedBlock* claim() noexcept override { return block_ = sink_.claim(); }
  void commit() noexcept override {
    truth_.sealed(epoch_, *block_, now_ns);
    beside_.sealed(*block_);
    sink_.commit();
  }
  std::int64_t now_ns = 0;

 private:
  RingSink sink_;
  Truth& truth_;
  EpochTruth& epoch_;
  BesideCheck& beside_;
  SealedBlock* block_ = nullptr;
};

/// One run of a node: from its start to its end or death.
struct NodeMachine::Program {
  Program(const FaultScenario& scenario, const VehicleConfig& vehicle, std::int32_t node, EpochTruth& of,
          Truth& all, VehicleChange& change, Disk& disk);

  EpochTruth& truth;
  BesideCheck beside;
  Ring ring;
  WitnessedSink sink;
  PreviewSlot preview;
  AcquireLink link;
  BlockPacker sealer;
  std::unique_ptr<SpoolFolder> spool;
  Backlog backlog;
  NodeLink uplink;
  HashedScans samples;
  std::int64_t next_index = 0;              // of the device
  std::int64_t first_index = -1;            // that is kept
  std::int64_t started_ns = 0;              // the device's index 0
  AbsenceCause ends = AbsenceCause::kNone;  // other than by the command of its recorder
  bool stopped = false;
  std::int64_t highest_owner = 0;
};

}  // namespace roadbalance::test
