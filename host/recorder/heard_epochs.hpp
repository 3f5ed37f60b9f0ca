#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <vector>

#include "common/bus/control_messages.hpp"
#include "common/link/receiver.hpp"
#include "common/record/record_state.hpp"
#include "common/types/clocks.hpp"
#include "host/recorder/device_notes.hpp"
#include "host/recorder/node_control.hpp"

namespace roadbalance {

/// Keeps the last heartbeat of each epoch that is being received, and concludes from it, from the receiver
/// and from the commands sent which epochs have ended and which nodes still hold blocks.
class HeardEpochs {
 public:
  /// @param receiver  and control: live as long as this
  HeardEpochs(const Receiver& receiver, const NodeControl& control)
      : receiver_(receiver), control_(control) {}

  /// Nobody was heard meanwhile, for this computer was held.
  void was_held(WallTime::duration held);
  /// @param notes  get what devices of the node have counted
  void take(const Heartbeat& heartbeat, WallTime now, bool wants_notes, std::vector<DeviceNote>& notes);
  /// No more heartbeats come: what was held back of the notes.
  void finish(std::vector<DeviceNote>& notes);

  /// By its last heartbeat.
  bool holds_blocks(NodeEpoch key) const;
  /// Its end is on the disk, or it is not received.
  bool has_ended(NodeEpoch key) const;
  /// It was heard, has its end on the disk, and holds nothing.
  bool has_let_go(NodeEpoch key) const;
  /// Every epoch that was started has its end on the disk.
  bool all_ended(WallTime now) const;
  /// Every one of these nodes was heard and has its end on the disk.
  bool have_ended(const std::vector<std::int32_t>& nodes, WallTime now) const;
  /// Every epoch whose end is on the disk reports that it keeps nothing any more, or is silent.
  bool all_have_let_go(WallTime now) const;

 private:
  struct Heard {
    WallTime at{};
    std::int64_t base = 0, next = 0;  ///< sequences that it held then: from base up to next
    DeviceNotes devices{};
  };
  bool is_superseded(NodeEpoch key, WallTime now) const;

  const Receiver& receiver_;
  const NodeControl& control_;
  std::map<NodeEpoch, Heard> heard_;
};

}  // namespace roadbalance
