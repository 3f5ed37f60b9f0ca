#include "common/bus/control.hpp"

#include <algorithm>
#include <wire/ack_t.hpp>
#include <wire/command_t.hpp>
#include <wire/heartbeat_t.hpp>
#include <wire/reply_t.hpp>
#include <wire/vehicle_t.hpp>

#include "common/bus/node_number.hpp"
#include "common/bus/wire_format.hpp"
#include "common/bus/wire_text.hpp"

namespace roadbalance {
namespace {

bool is_index(std::int64_t value) {
  return 0 <= value && value <= kIndexLimit;
}

template <typename Enum>
bool is_one_of(std::int32_t value, Enum first, Enum last) {
  return static_cast<std::int32_t>(first) <= value && value <= static_cast<std::int32_t>(last);
}

bool in_bounds(const wire::heartbeat_t& m) {
  return is_node(m.node) && is_one_of(m.state, NodeState::kPreview, NodeState::kFailed) && m.base >= 1 &&
         m.next >= m.base && is_index(m.next) && -kClockLimit_ns <= m.time_ns &&
         m.time_ns <= kClockLimit_ns && is_index(m.owner) && m.ring_used >= 0 &&
         m.ring_capacity >= m.ring_used && is_index(m.ring_capacity) && is_index(m.spool_used) &&
         is_index(m.spool_failures) && is_index(m.scans_refused) &&
         is_one_of(m.time_base, TimeBase::kOwn, TimeBase::kShared) && 0 <= m.clock_port &&
         m.clock_port <= 65'535 && is_index(m.scans_sampled) && is_index(m.scans_missing) &&
         is_index(m.blocks_sent) && is_index(m.blocks_repaired) && is_index(m.blocks_unsent) &&
         std::all_of(std::begin(m.device_counts), std::end(m.device_counts), is_index);
}

// Missing ranges ascend, do not touch the part that has arrived, and do not overlap.
bool in_bounds(const wire::ack_t& m) {
  if (!is_node(m.node) || m.incarnation < 1 || !is_index(m.incarnation) || m.number < 1 || m.durable < 0 ||
      m.received < m.durable || m.credit < m.received || !is_index(m.credit) || m.missing < 0 ||
      m.missing > static_cast<std::int32_t>(kMaxMissingRanges))
    return false;
  std::int64_t before = m.received;
  for (std::int32_t k = 0; k < m.missing; ++k) {
    if (m.missing_first[k] <= before || m.missing_last[k] < m.missing_first[k]) return false;
    before = m.missing_last[k];
  }
  return is_index(before);
}

}  // namespace

static_assert(sizeof(wire::vehicle_t::text) == kMostVehiclePart);
static_assert(kDeviceCounters <= sizeof(wire::heartbeat_t::device_counts) / sizeof(std::int64_t));

std::vector<std::uint8_t> encode(const Heartbeat& h) {
  wire::heartbeat_t m{};
  m.node = h.node;
  m.epoch = h.epoch;
  m.base = h.base;
  m.next = h.next;
  m.time_ns = h.time_ns;
  m.state = static_cast<std::int32_t>(h.state);
  m.owner = h.owner;
  m.ring_used = h.ring_used;
  m.ring_capacity = h.ring_capacity;
  m.spool_used = h.spool_used;
  m.spool_failures = h.spool_failures;
  m.scans_sampled = h.scans_sampled;
  m.scans_missing = h.scans_missing;
  m.scans_refused = h.scans_refused;
  m.blocks_sent = h.blocks_sent;
  m.blocks_repaired = h.blocks_repaired;
  m.blocks_unsent = h.blocks_unsent;
  m.acks_refused = h.acks_refused;
  std::copy(h.encoder_faults.begin(), h.encoder_faults.end(), m.encoder_faults);
  m.unreferenced_blocks = h.unreferenced_blocks;
  std::copy(h.device_counts.begin(), h.device_counts.end(), m.device_counts);
  m.time_base = static_cast<std::int32_t>(h.time_base);
  m.clock_address = static_cast<std::int32_t>(h.clock_address);
  m.clock_port = h.clock_port;
  m.vehicle_crc32c = static_cast<std::int32_t>(h.vehicle_crc32c);
  return wire_format::encode_with_crc(m);
}

std::optional<Heartbeat> decode_heartbeat(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::heartbeat_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  Heartbeat h;
  h.node = m->node;
  h.epoch = m->epoch;
  h.base = m->base;
  h.next = m->next;
  h.time_ns = m->time_ns;
  h.state = static_cast<NodeState>(m->state);
  h.owner = m->owner;
  h.ring_used = m->ring_used;
  h.ring_capacity = m->ring_capacity;
  h.spool_used = m->spool_used;
  h.spool_failures = m->spool_failures;
  h.scans_sampled = m->scans_sampled;
  h.scans_missing = m->scans_missing;
  h.scans_refused = m->scans_refused;
  h.blocks_sent = m->blocks_sent;
  h.blocks_repaired = m->blocks_repaired;
  h.blocks_unsent = m->blocks_unsent;
  h.acks_refused = m->acks_refused;
  std::copy_n(m->encoder_faults, h.encoder_faults.size(), h.encoder_faults.begin());
  h.unreferenced_blocks = m->unreferenced_blocks;
  std::copy_n(m->device_counts, h.device_counts.size(), h.device_counts.begin());
  h.time_base = static_cast<TimeBase>(m->time_base);
  h.clock_address = static_cast<std::uint32_t>(m->clock_address);
  h.clock_port = static_cast<std::uint16_t>(m->clock_port);
  h.vehicle_crc32c = static_cast<std::uint32_t>(m->vehicle_crc32c);
  return h;
}

std::vector<std::uint8_t> encode(const Ack& a) {
  wire::ack_t m{};
  m.node = a.node;
  m.epoch = a.epoch;
  m.incarnation = a.incarnation;
  m.number = a.number;
  m.received = a.received;
  m.durable = a.durable;
  m.credit = a.credit;
  const std::size_t ranges = std::min(a.missing.size(), kMaxMissingRanges);
  m.missing = static_cast<std::int32_t>(ranges);
  for (std::size_t k = 0; k < ranges; ++k) {
    m.missing_first[k] = a.missing[k].first;
    m.missing_last[k] = a.missing[k].last;
  }
  return wire_format::encode_with_crc(m);
}

std::optional<Ack> decode_ack(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::ack_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  Ack a;
  a.node = m->node;
  a.epoch = m->epoch;
  a.incarnation = m->incarnation;
  a.number = m->number;
  a.received = m->received;
  a.durable = m->durable;
  a.credit = m->credit;
  for (std::int32_t k = 0; k < m->missing; ++k)
    a.missing.push_back({m->missing_first[k], m->missing_last[k]});
  return a;
}

std::vector<std::uint8_t> encode(const Command& c) {
  wire::command_t m{};
  m.node = c.node;
  m.request = c.request;
  m.incarnation = c.incarnation;
  m.verb = static_cast<std::int32_t>(c.verb);
  m.epoch = c.epoch;
  m.vehicle_crc32c = static_cast<std::int32_t>(c.vehicle_crc32c);
  return wire_format::encode_with_crc(m);
}

// An unknown verb passes: the node answers kUnknownVerb, so that a newer host learns of it.
std::optional<Command> decode_command(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::command_t>(bytes);
  if (!m || !is_node(m->node) || m->incarnation < 1 || !is_index(m->incarnation)) return std::nullopt;
  return Command{.node = m->node,
                 .request = m->request,
                 .incarnation = m->incarnation,
                 .verb = static_cast<Verb>(m->verb),
                 .epoch = m->epoch,
                 .vehicle_crc32c = static_cast<std::uint32_t>(m->vehicle_crc32c)};
}

std::vector<std::uint8_t> encode(const Reply& r) {
  wire::reply_t m{};
  m.node = r.node;
  m.epoch = r.epoch;
  m.request = r.request;
  m.result = static_cast<std::int32_t>(r.result);
  m.sequence = r.sequence;
  wire_text::put_text(r.text, m.text, m.size);
  return wire_format::encode_with_crc(m);
}

std::optional<Reply> decode_reply(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::reply_t>(bytes);
  if (!m || !is_node(m->node) || !is_index(m->sequence) ||
      !is_one_of(m->result, CommandError::kNone, CommandError::kVehicleRefused))
    return std::nullopt;
  const auto text = wire_text::text_of(m->text, m->size);
  if (!text) return std::nullopt;
  return Reply{.node = m->node,
               .epoch = m->epoch,
               .request = m->request,
               .result = static_cast<CommandError>(m->result),
               .sequence = m->sequence,
               .text = *text};
}

std::vector<std::uint8_t> encode(const VehiclePart& v) {
  wire::vehicle_t m{};
  m.node = v.node;
  m.incarnation = v.incarnation;
  m.vehicle_crc32c = static_cast<std::int32_t>(v.vehicle_crc32c);
  m.part = v.part;
  m.parts = v.parts;
  m.size = static_cast<std::int32_t>(std::min(v.text.size(), kMostVehiclePart));
  std::copy_n(v.text.begin(), m.size, m.text);
  return wire_format::encode_with_crc(m);
}

// A part may end amid a character; the whole text is checked by its parser.
std::optional<VehiclePart> decode_vehicle_part(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::vehicle_t>(bytes);
  if (!m || !is_node(m->node) || m->incarnation < 1 || !is_index(m->incarnation) || m->parts < 1 ||
      m->parts > static_cast<std::int32_t>(kMostVehicleParts) || m->part < 0 || m->part >= m->parts ||
      m->size < 1 || m->size > static_cast<std::int32_t>(kMostVehiclePart))
    return std::nullopt;
  return VehiclePart{.node = m->node,
                     .incarnation = m->incarnation,
                     .vehicle_crc32c = static_cast<std::uint32_t>(m->vehicle_crc32c),
                     .part = m->part,
                     .parts = m->parts,
                     .text = std::string(m->text, m->text + m->size)};
}

}  // namespace roadbalance
