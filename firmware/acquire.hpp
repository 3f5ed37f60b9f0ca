#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <stop_token>

#include "common/frontend/front_end.hpp"
#include "common/types/clocks.hpp"
#include "common/types/device_report.hpp"
#include "firmware/block_packer.hpp"

namespace roadbalance {

/// All that passes between acquire and uplink beside the ring and the preview.  Each member has one writer.
struct AcquireLink {
  /// An instant to begin or to end that nobody has asked for, and one that is over.
  static constexpr WallTime kNotAsked = WallTime::max(), kAtOnce = WallTime::min();

  // Written by uplink.
  std::atomic<WallTime> start_at{kNotAsked}, stop_at{kNotAsked};
  std::atomic<std::int64_t> uplink_turns{0};  ///< of its loop

  // Written by acquire.
  std::atomic<NodeState> state{
      NodeState::kPreview};  ///< kEnded and kFailed are final: nothing more is sealed
  std::atomic<AbsenceCause> end_cause{AbsenceCause::kNone};  ///< stored before the final state
  std::atomic<bool> device_ended{false};       ///< or has failed: there is nothing more to be had from it
  std::atomic<std::int64_t> acquire_turns{0};  ///< of its loop
  std::atomic<std::int64_t> time_ns{0};
  std::atomic<std::int64_t> scans_sampled{0}, scans_missing{0}, scans_refused{0}, unreferenced_blocks{0};
  std::array<DeviceReport, kEncoderLines> encoder{DeviceReport("encoder of line 0"),
                                                  DeviceReport("encoder of line 1")};
  std::array<std::atomic<std::int32_t>, 2 * kEncoderLines> mark_counts{};  ///< as in the heartbeat

  bool ended() const {
    const NodeState now = state.load(std::memory_order_acquire);
    return now == NodeState::kEnded || now == NodeState::kFailed;
  }
};

/// Process: front end -> sealed blocks.  The one process with a deadline: it never allocates, locks, logs,
/// throws or waits for anything but its device.
///
/// Starts and stops at the instants of `link`.  A device that waits for its reader is read only when started
/// and while `sink` has room for all that one read can produce; it starts and stops at once.  Ends when
/// everything up to stop or the device's end is in the sink with its end, or when asked to stop: then with
/// what the sink takes at once.
void acquire(std::stop_token stop, FrontEnd& front_end, BlockPacker& packer, BlockSink& sink,
             AcquireLink& link) noexcept;

/// Reports the state of acquire after each read.
void report_progress(const BlockPacker& packer, NodeState state, AcquireLink& link) noexcept;

/// A read takes at most so many.
inline constexpr std::size_t kScansPerRead = 256;
inline constexpr std::size_t kEdgesPerRead = 4096;
inline constexpr std::size_t kSignalsPerRead = 1024;

}  // namespace roadbalance
