#include "common/bus/notes.hpp"

#include <algorithm>
#include <limits>
#include <wire/commit_t.hpp>
#include <wire/journal_t.hpp>
#include <wire/note_t.hpp>

#include "common/bus/fields.hpp"
#include "common/types/bounded_time.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<Journal> {
  using Wire = wire::journal_t;
  static void list(auto& field, auto& j, auto& m) {
    field(j.node, m.node, is_node);
    field(j.epoch, m.epoch);
    field(j.time_us, m.time_us);
    field(j.first_sequence, m.first_sequence, is_index);
    field(j.last_sequence, m.last_sequence,
          [&m](std::int64_t last) { return is_index(last) && last >= m.first_sequence - 1; });
    field(j.first_scan, m.first_scan, is_index);
    field(j.next_scan, m.next_scan, is_index);
    field(j.scans, m.scans, is_index);
    field(j.scans_missing, m.scans_missing, is_index);
    field(j.channel_crc, m.channel_crc);
    NodeLosses::list([&field](const char*, auto& count, auto& wire) { field(count, wire); }, j.node_losses,
                     m);
    field(j.refused, m.refused);
    field(j.rivals, m.rivals);
    field(j.unsent, m.unsent);
    field(j.disk_failures, m.disk_failures);
  }
};

template <>
struct Fields<Note> {
  using Wire = wire::note_t;
  static void list(auto& field, auto& n, auto& m) {
    field(n.time_us, m.time_us, within(-kUtcLimit_us, kUtcLimit_us));
    field(n.host_ns, m.host_ns, is_clock);
    field(n.incarnation, m.incarnation);
    field(n.kind, m.kind, within(NoteKind::kStarted, NoteKind::kLast));
    field(n.a, m.a);
    field(n.b, m.b);
    const bool names_segment = m.kind == static_cast<std::int32_t>(NoteKind::kSegmentAbandoned) ||
                               m.kind == static_cast<std::int32_t>(NoteKind::kSegmentDeleted);
    // Segments are numbered from 1 in an int.
    field.require(!names_segment || (within(1, std::numeric_limits<int>::max())(m.a) && m.b >= 0));
    field.text_made_plain(n.text, m.text, m.size);
  }
};

template <>
struct Fields<Commit> {
  using Wire = wire::commit_t;
  static void list(auto& field, auto& c, auto& m) {
    field(c.bytes, m.bytes, at_least(0));
    field(c.headers_from, m.headers_from, at_least(0));
    field(c.headers_crc32c, m.headers_crc32c);
  }
};

}  // namespace wire_fields

static_assert(sizeof(wire::note_t::text) == kMaxNoteBytes);

void NodeLosses::raise(const NodeLosses& said) {
  list_counts([](const char*, auto& count, auto other) { count = std::max(count, other); }, *this, said);
}

std::vector<std::uint8_t> encode(const Journal& journal) {
  return wire_fields::encode(journal);
}
std::vector<std::uint8_t> encode(const Note& note) {
  return wire_fields::encode(note);
}
std::vector<std::uint8_t> encode(const Commit& commit) {
  return wire_fields::encode(commit);
}
std::optional<Journal> decode_journal(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Journal>(bytes);
}
std::optional<Note> decode_note(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Note>(bytes);
}
std::optional<Commit> decode_commit(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Commit>(bytes);
}

}  // namespace roadbalance
