#include "common/bus/control_messages.hpp"

#include <wire/ack_t.hpp>
#include <wire/command_t.hpp>
#include <wire/heartbeat_t.hpp>
#include <wire/reply_t.hpp>
#include <wire/vehicle_t.hpp>

#include "common/bus/fields.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<Heartbeat> {
  using Wire = wire::heartbeat_t;
  static void list(auto& field, auto& h, auto& m) {
    field(h.node, m.node, is_node);
    field(h.epoch, m.epoch);
    field(h.base, m.base, at_least(1));
    field(h.next, m.next, within(m.base, kIndexLimit));
    field(h.time_ns, m.time_ns, is_clock);
    field(h.state, m.state, up_to(NodeState::kFailed));
    field(h.owner, m.owner, is_index);
    field(h.ring_used, m.ring_used, at_least(0));
    field(h.ring_capacity, m.ring_capacity, within(m.ring_used, kIndexLimit));
    field(h.spool_used, m.spool_used, is_index);
    field(h.spool_failures, m.spool_failures, is_index);
    field(h.scans_sampled, m.scans_sampled, is_index);
    field(h.scans_missing, m.scans_missing, is_index);
    field(h.scans_refused, m.scans_refused, is_index);
    field(h.blocks_sent, m.blocks_sent, is_index);
    field(h.blocks_repaired, m.blocks_repaired, is_index);
    field(h.blocks_unsent, m.blocks_unsent, is_index);
    field(h.acks_refused, m.acks_refused);
    field(h.encoder_faults, m.encoder_faults);
    field(h.mark_counts, m.mark_counts, at_least(0));
    field(h.unreferenced_blocks, m.unreferenced_blocks);
    field(h.device_counts, m.device_counts, is_index);
    field(h.time_base, m.time_base, up_to(TimeBase::kShared));
    field(h.clock_address, m.clock_address);
    field(h.clock_port, m.clock_port, up_to(65'535));
    field(h.vehicle_crc32c, m.vehicle_crc32c);
    field(h.end_cause, m.end_cause, up_to(AbsenceCause::kProgramEnded));
  }
};

template <>
struct Fields<Ack> {
  using Wire = wire::ack_t;
  static void list(auto& field, auto& a, auto& m) {
    field(a.node, m.node, is_node);
    field(a.epoch, m.epoch);
    field(a.incarnation, m.incarnation, within(1, kIndexLimit));
    field(a.number, m.number, at_least(1));
    field(a.received, m.received);
    field(a.durable, m.durable, within(0, m.received));
    field(a.credit, m.credit, within(m.received, kIndexLimit));
    // Missing ranges ascend, do not touch the part that has arrived, and do not overlap.
    std::int64_t before = m.received;
    field.first_rows(a.missing, m.missing, kMaxMissingRanges, [&](auto& range, std::size_t k) {
      field(range.first, m.missing_first[k]);
      field.require(before < m.missing_first[k]);
      field(range.last, m.missing_last[k], within(m.missing_first[k], kIndexLimit));
      before = m.missing_last[k];
    });
  }
};

template <>
struct Fields<Command> {
  using Wire = wire::command_t;
  static void list(auto& field, auto& c, auto& m) {
    field(c.node, m.node, is_node);
    field(c.request, m.request);
    field(c.incarnation, m.incarnation, within(1, kIndexLimit));
    field(c.verb,
          m.verb);  // one of a newer host passes: the node answers kUnknownVerb, so that it learns of it
    field(c.epoch, m.epoch);
    field(c.delay_us, m.delay_us, within(-kLongestDelay_us, kLongestDelay_us));
    field(c.vehicle_crc32c, m.vehicle_crc32c);
  }
};

template <>
struct Fields<Reply> {
  using Wire = wire::reply_t;
  static void list(auto& field, auto& r, auto& m) {
    field(r.node, m.node, is_node);
    field(r.epoch, m.epoch);
    field(r.request, m.request);
    field(r.result, m.result, up_to(CommandError::kVehicleRefused));
    field(r.sequence, m.sequence, is_index);
    field.text(r.text, m.text, m.size);
  }
};

template <>
struct Fields<VehiclePart> {
  using Wire = wire::vehicle_t;
  static void list(auto& field, auto& v, auto& m) {
    field(v.node, m.node, is_node);
    field(v.incarnation, m.incarnation, within(1, kIndexLimit));
    field(v.vehicle_crc32c, m.vehicle_crc32c);
    field(v.part, m.part);
    field(v.parts, m.parts, within(1, kMostVehicleParts));
    field.require(below(m.parts)(m.part));
    // A part may end amid a character; the whole text is checked by its parser.
    field.bytes(v.text, m.text, m.size, 1);
  }
};

}  // namespace wire_fields

static_assert(sizeof(wire::vehicle_t::text) == kMostVehiclePart);

std::vector<std::uint8_t> encode(const Heartbeat& message) {
  return wire_fields::encode(message);
}
std::vector<std::uint8_t> encode(const Ack& message) {
  return wire_fields::encode(message);
}
std::vector<std::uint8_t> encode(const Command& message) {
  return wire_fields::encode(message);
}
std::vector<std::uint8_t> encode(const Reply& message) {
  return wire_fields::encode(message);
}
std::vector<std::uint8_t> encode(const VehiclePart& message) {
  return wire_fields::encode(message);
}

std::optional<Heartbeat> decode_heartbeat(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Heartbeat>(bytes);
}
std::optional<Ack> decode_ack(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Ack>(bytes);
}
std::optional<Command> decode_command(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Command>(bytes);
}
std::optional<Reply> decode_reply(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Reply>(bytes);
}
std::optional<VehiclePart> decode_vehicle_part(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<VehiclePart>(bytes);
}

}  // namespace roadbalance
