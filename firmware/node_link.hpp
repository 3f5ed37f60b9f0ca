#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/bus/publish.hpp"
#include "common/link/backlog.hpp"
#include "common/link/sender.hpp"
#include "common/types/clocks.hpp"
#include "firmware/acquire.hpp"
#include "firmware/commands.hpp"
#include "firmware/preview_slot.hpp"

namespace roadbalance {

/// Where a node's clock is asked for, as in its heartbeats.
struct NodeClockAddress {
  TimeBase time_base = TimeBase::kOwn;
  std::uint32_t address = 0;  ///< IPv4, as a number; 0: there is none
  std::uint16_t port = 0;
};

/// The node's half of the bus without a bus: datagrams and time come in, datagrams go out.  Its memory is
/// fixed; in steady state it allocates for heartbeats and replies only.
class NodeLink {
 public:
  /// @param clock    at each heartbeat
  /// @param reports  of the node's devices; their sums, with what its encoders count, go into the heartbeat
  NodeLink(
      std::int32_t node, std::int64_t epoch, Backlog& backlog, PreviewSlot& preview, AcquireLink& link,
      VehicleChange& vehicle, std::function<NodeClockAddress()> clock = [] { return NodeClockAddress(); },
      std::vector<const DeviceReport*> reports = {});

  /// A message on ack_channel(node), command_channel(node) or vehicle_channel(node); any other is ignored.
  void take(std::string_view channel, std::span<const std::uint8_t> bytes, WallTime now);

  /// Moves blocks to the spool if it must, then sends what is due: blocks, the preview, replies, ten
  /// heartbeats a second, forty while blocks are held and none goes out.  True if there were blocks: more may
  /// be due at once.
  bool turn(WallTime now, const Publish& publish);
  /// So many blocks that a turn published did not leave this computer after all.
  void count_unsent(std::size_t blocks) { blocks_unsent_ += static_cast<std::int64_t>(blocks); }

  /// While there is no bus, in place of turn(): moves blocks to the spool if it must.
  void relieve(WallTime now) {
    link_.uplink_turns.fetch_add(1, std::memory_order_relaxed);
    backlog_.relieve(now);
  }

  /// Acquire has ended, its owner has everything durable, and every command is answered; or before anything
  /// was kept another vehicle.toml is wanted.
  bool finished() const;
  std::int64_t owner() const { return sender_.owner(); }
  const Sender& sender() const { return sender_; }

  /// The last words: a heartbeat, again and again because any may be lost.
  void farewell(const Publish& publish);

 private:
  bool send_blocks(WallTime now, const Publish& publish);
  void send_heartbeat(const Publish& publish);

  const std::int32_t node_;
  const std::int64_t epoch_;
  Backlog& backlog_;
  PreviewSlot& preview_;
  AcquireLink& link_;
  VehicleChange& vehicle_;
  const std::function<NodeClockAddress()> clock_;
  const std::vector<const DeviceReport*> reports_;
  Sender sender_;
  Commands commands_;
  const std::string ack_channel_, command_channel_, vehicle_channel_, reply_channel_, heartbeat_channel_,
      preview_channel_;
  std::array<std::string, kBlockKinds> block_channel_;  // [BlockKind]
  WallTime next_heartbeat_{}, heartbeat_at_{};
  WallTime quiet_since_{};  ///< blocks are held, and none has gone out since
  WallTime owner_heard_{};
  std::int64_t blocks_unsent_ = 0;
};

}  // namespace roadbalance
