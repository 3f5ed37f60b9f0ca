#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "common/config/vehicle_config.hpp"
#include "common/frontend/front_end.hpp"
#include "common/types/blocks.hpp"

namespace roadbalance {

/// Hands over every block of an epoch, as a node would seal them, without threads and without a bus.
class EpochPacker {
 public:
  using Take = std::function<void(const SealedBlock&)>;

  /// @param jump  cause of a jump in the scan index
  /// @throws what `take` throws, as do the others
  EpochPacker(const VehicleConfig& vehicle, const NodeConfig& node, std::int64_t epoch, Take take,
              GapCause jump = GapCause::kDeviceOverrun);
  ~EpochPacker();

  /// The epoch has the scans of these indices, [begin, end), with their instants; those that are not added
  /// at its begin and its end are missing, as a jump.  Before the first add(), and before end().
  void begin_at(std::int64_t index, NodeTime time);
  void end_at(std::int64_t index, NodeTime time);
  /// As BlockPacker::add: the result of one read of a front end.
  void add(std::span<const Scan> scans, std::span<const Edge> edges,
           std::span<const SignalSample> signals = {}, bool more_edges = false);
  /// Nothing follows.
  void end();

  /// WheelEncoder::mark_counts of the encoder of a line.
  std::array<int, 2> mark_counts(int line) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Reads a front end to its end and hands over every block of the epoch.
///
/// @throws std::runtime_error if the front end fails; what `take` throws
void pack_epoch(FrontEnd& front_end, const VehicleConfig& vehicle, const NodeConfig& node, std::int64_t epoch,
                const EpochPacker::Take& take, GapCause jump = GapCause::kDeviceOverrun);

}  // namespace roadbalance
