#include "firmware/node_link.hpp"

#include <algorithm>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/control_messages.hpp"

namespace roadbalance {

namespace {

using namespace std::chrono_literals;
constexpr auto kHeartbeatPeriod = 100ms;
// While blocks are held and none goes out, at the start and at the end, only heartbeats report them: one that
// the network loses must not cost a whole period.
constexpr auto kQuietPeriod = 25ms;
constexpr auto kOwnerSilence = 500ms;
constexpr int kLastHeartbeats = 3;

}  // namespace

NodeLink::NodeLink(std::int32_t node, std::int64_t epoch, Backlog& backlog, PreviewSlot& preview,
                   AcquireLink& link, VehicleChange& vehicle, std::function<NodeClockAddress()> clock,
                   std::vector<const DeviceReport*> reports)
    : node_(node),
      epoch_(epoch),
      backlog_(backlog),
      preview_(preview),
      link_(link),
      vehicle_(vehicle),
      clock_(std::move(clock)),
      reports_(std::move(reports)),
      sender_(backlog, node, epoch),
      commands_(node, epoch, backlog, sender_, link, vehicle),
      ack_channel_(ack_channel(node)),
      command_channel_(command_channel(node)),
      vehicle_channel_(vehicle_channel(node)),
      reply_channel_(reply_channel(node)),
      heartbeat_channel_(heartbeat_channel(node)),
      preview_channel_(preview_channel(node)) {
  for (std::size_t kind = 0; kind < block_channel_.size(); ++kind)
    block_channel_[kind] = block_channel(node, static_cast<BlockKind>(kind));
}

void NodeLink::take(std::string_view channel, std::span<const std::uint8_t> bytes, WallTime now) {
  if (channel == ack_channel_) {
    const auto ack = decode_ack(bytes);
    if (!ack || !sender_.take(*ack, now)) return;
    // The cable is in again: the sooner the recorder gets the heartbeat, the sooner it asks.
    if (now - owner_heard_ > kOwnerSilence) next_heartbeat_ = now;
    owner_heard_ = now;
  } else if (channel == command_channel_) {
    if (const auto command = decode_command(bytes)) commands_.take(*command, now);
  } else if (channel == vehicle_channel_) {
    if (const auto part = decode_vehicle_part(bytes); part && part->node == node_) vehicle_.take(*part);
  }
}

bool NodeLink::turn(WallTime now, const Publish& publish) {
  relieve(now);
  const bool busy = send_blocks(now, publish);
  if (busy || backlog_.used() == 0) quiet_since_ = now;
  if (const SealedBlock* block = preview_.read()) publish(preview_channel_, block->bytes());
  while (const auto answer = commands_.next_reply()) publish(reply_channel_, encode(*answer));
  if (now - quiet_since_ >= kQuietPeriod)
    next_heartbeat_ = std::min(next_heartbeat_, heartbeat_at_ + kQuietPeriod);
  if (now >= next_heartbeat_) {
    send_heartbeat(publish);
    heartbeat_at_ = now;
    next_heartbeat_ = now + kHeartbeatPeriod;
  }
  return busy;
}

bool NodeLink::send_blocks(WallTime now, const Publish& publish) {
  const auto due = sender_.due(now);
  for (const std::int64_t sequence : due) {
    if (sequence < backlog_.base()) continue;  // the disk gave up the one before it
    const SealedBlock* block = backlog_.get(sequence);
    if (!block) continue;
    if (!publish(block_channel_[static_cast<std::size_t>(block->kind)], block->bytes())) ++blocks_unsent_;
  }
  return !due.empty();
}

bool NodeLink::finished() const {
  return vehicle_.wanted() || (link_.ended() && backlog_.used() == 0 && !commands_.waiting());
}

void NodeLink::farewell(const Publish& publish) {
  for (int k = 0; k < kLastHeartbeats; ++k) send_heartbeat(publish);
}

// The state is read first: once it is the last, `next` is behind the last block.
void NodeLink::send_heartbeat(const Publish& publish) {
  Heartbeat beat;
  beat.node = node_;
  beat.epoch = epoch_;
  beat.state = link_.state.load(std::memory_order_acquire);
  beat.base = backlog_.base();
  beat.next = backlog_.next();
  beat.time_ns = link_.time_ns.load();
  beat.owner = sender_.owner();
  beat.ring_used = beat.next - beat.base;
  beat.ring_capacity = std::max(backlog_.capacity(), beat.ring_used);
  beat.spool_used = backlog_.spooled();
  beat.spool_failures = backlog_.spool_failures();
  beat.scans_sampled = link_.scans_sampled.load();
  beat.scans_missing = link_.scans_missing.load();
  beat.scans_refused = link_.scans_refused.load();
  beat.blocks_sent = sender_.blocks_sent();
  beat.blocks_repaired = sender_.blocks_repaired();
  beat.blocks_unsent = blocks_unsent_;
  beat.acks_refused = sender_.acks_refused();
  for (std::size_t line = 0; line < kEncoderLines; ++line)
    beat.encoder_faults[line] = link_.encoder[line].of(DeviceCounter::kFaultyTurns);
  for (std::size_t k = 0; k < beat.mark_counts.size(); ++k) beat.mark_counts[k] = link_.mark_counts[k].load();
  beat.unreferenced_blocks = link_.unreferenced_blocks.load();
  for (std::size_t k = 0; k < kDeviceCounters; ++k) {
    for (const DeviceReport* report : reports_)
      beat.device_counts[k] += report->of(static_cast<DeviceCounter>(k));
    for (const DeviceReport& encoder : link_.encoder)
      beat.device_counts[k] += encoder.of(static_cast<DeviceCounter>(k));
  }
  const NodeClockAddress clock = clock_();
  beat.time_base = clock.time_base;
  beat.clock_address = clock.address;
  beat.clock_port = clock.port;
  beat.vehicle_crc32c = vehicle_.in_force();
  beat.end_cause = link_.end_cause.load();
  publish(heartbeat_channel_, encode(beat));
}

}  // namespace roadbalance
