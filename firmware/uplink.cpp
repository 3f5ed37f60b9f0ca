#include "firmware/uplink.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>

#include "common/bus/bus.hpp"
#include "common/bus/control.hpp"
#include "common/link/sender.hpp"
#include "firmware/commands.hpp"

namespace roadbalance {

namespace {

using namespace std::chrono_literals;
constexpr auto kHeartbeatPeriod = 100ms;
constexpr auto kIdleWait = 2ms;
constexpr auto kFarewell = 1s;      // told to stop, how long the owner may take to call the rest durable
constexpr int kLastHeartbeats = 3;  // after the end; any of them may be lost

class Uplink {
 public:
  Uplink(const std::string& bus_url, std::int32_t node, std::int64_t epoch, Ring& ring, PreviewSlot& preview,
         AcquireLink& link)
      : node_(node),
        epoch_(epoch),
        ring_(ring),
        preview_(preview),
        link_(link),
        sender_(ring, node, epoch),
        commands_(node, epoch, ring, sender_, link),
        bus_(bus_url) {
    for (std::size_t kind = 0; kind < channels_.size(); ++kind)
      channels_[kind] = block_channel(node, static_cast<BlockKind>(kind));
    bus_.subscribe(ack_channel(node), [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto ack = decode_ack(bytes)) sender_.take(*ack, WallClock::now());
    });
    bus_.subscribe(command_channel(node), [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto command = decode_command(bytes)) commands_.take(*command, WallClock::now());
    });
  }

  void run(std::stop_token stop) {
    std::optional<WallTime> told_to_stop;
    while (true) {
      const WallTime now = WallClock::now();
      if (stop.stop_requested() && !told_to_stop) told_to_stop = now;
      if (told_to_stop && (now - *told_to_stop > kFarewell || sender_.owner() == 0)) break;
      const bool busy = send_blocks(now);
      reply();
      if (now >= next_heartbeat_) {
        send_heartbeat();
        next_heartbeat_ = now + kHeartbeatPeriod;
      }
      if (ended() && ring_.used() == 0 && !commands_.waiting()) break;
      bus_.handle(busy ? 0ms : kIdleWait);
    }
    for (int i = 0; i < kLastHeartbeats; ++i) send_heartbeat();
  }

 private:
  bool ended() const {
    const NodeState state = link_.state.load(std::memory_order_acquire);
    return state == NodeState::kEnded || state == NodeState::kFailed;
  }

  bool send_blocks(WallTime now) {
    const auto due = sender_.due(now);
    for (const std::int64_t sequence : due) {
      const SealedBlock& block = ring_.get(sequence);
      if (!bus_.publish(channels_[static_cast<std::size_t>(block.kind)], block.bytes())) ++blocks_unsent_;
    }
    if (const SealedBlock* block = preview_.read()) bus_.publish(preview_channel(node_), block->bytes());
    return !due.empty();
  }

  void reply() {
    while (const auto answer = commands_.next_reply()) bus_.publish(reply_channel(node_), encode(*answer));
  }

  void send_heartbeat() {
    Heartbeat beat;
    beat.node = node_;
    beat.epoch = epoch_;
    beat.state = link_.state.load(std::memory_order_acquire);
    beat.base = ring_.base();
    beat.next = ring_.next();
    beat.time_ns = link_.time_ns.load();
    beat.owner = sender_.owner();
    beat.ring_used = beat.next - beat.base;
    beat.ring_capacity = ring_.capacity();
    beat.scans_sampled = link_.scans_sampled.load();
    beat.scans_missing = link_.scans_missing.load();
    beat.blocks_sent = sender_.blocks_sent();
    beat.blocks_repaired = sender_.blocks_repaired();
    beat.blocks_unsent = blocks_unsent_;
    beat.acks_refused = sender_.acks_refused();
    for (std::size_t line = 0; line < kEncoderLines; ++line)
      beat.encoder_faults[line] = link_.encoder_faults[line].load();
    beat.unreferenced_blocks = link_.unreferenced_blocks.load();
    bus_.publish(heartbeat_channel(node_), encode(beat));
  }

  const std::int32_t node_;
  const std::int64_t epoch_;
  Ring& ring_;
  PreviewSlot& preview_;
  AcquireLink& link_;
  Sender sender_;
  Commands commands_;
  std::array<std::string, 5> channels_;  // [BlockKind]
  Bus bus_;
  WallTime next_heartbeat_{};
  std::int64_t blocks_unsent_ = 0;
};

}  // namespace

void uplink(std::stop_token stop, const std::string& bus_url, std::int32_t node, std::int64_t epoch,
            Ring& ring, PreviewSlot& preview, AcquireLink& link) {
  Uplink(bus_url, node, epoch, ring, preview, link).run(stop);
}

}  // namespace roadbalance
