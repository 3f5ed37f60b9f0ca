#include "common/bus/notes.hpp"

#include <algorithm>
#include <limits>
#include <wire/commit_t.hpp>
#include <wire/journal_t.hpp>
#include <wire/note_t.hpp>

#include "common/bus/wire_format.hpp"
#include "common/bus/wire_text.hpp"
#include "common/clock/bounded_time.hpp"
#include "common/link/block.hpp"

namespace roadbalance {
namespace {

static_assert(sizeof(wire::note_t::text) == kMaxNoteBytes);

static_assert(kDeviceCounters <= sizeof(wire::journal_t::device_counts) / sizeof(std::int64_t));

bool within(std::int64_t value, std::int64_t limit) {
  return -limit <= value && value <= limit;
}

bool is_index(std::int64_t value) {
  return 0 <= value && value <= kIndexLimit;
}

void put(const NodeLosses& losses, wire::journal_t& m) {
  m.repaired = losses.repaired;
  m.spool_failures = losses.spool_failures;
  m.scans_refused = losses.scans_refused;
  m.blocks_unsent = losses.blocks_unsent;
  m.acks_refused = losses.acks_refused;
  std::copy(losses.encoder_faults.begin(), losses.encoder_faults.end(), m.encoder_faults);
  m.unreferenced_blocks = losses.unreferenced_blocks;
  std::copy(losses.device_counts.begin(), losses.device_counts.end(), m.device_counts);
}

NodeLosses node_losses_of(const wire::journal_t& m) {
  NodeLosses losses{.repaired = m.repaired,
                    .spool_failures = m.spool_failures,
                    .scans_refused = m.scans_refused,
                    .blocks_unsent = m.blocks_unsent,
                    .acks_refused = m.acks_refused,
                    .unreferenced_blocks = m.unreferenced_blocks};
  std::copy_n(m.encoder_faults, losses.encoder_faults.size(), losses.encoder_faults.begin());
  std::copy_n(m.device_counts, losses.device_counts.size(), losses.device_counts.begin());
  return losses;
}

bool in_bounds(const wire::journal_t& m) {
  return 1 <= m.node && m.node <= kLastNode && is_index(m.first_sequence) && is_index(m.last_sequence) &&
         m.last_sequence >= m.first_sequence - 1 && is_index(m.first_scan) && is_index(m.next_scan) &&
         is_index(m.scans) && is_index(m.scans_missing);
}

// Segments are numbered from 1 in an int.
bool is_good_for_its_kind(const wire::note_t& m) {
  const auto kind = static_cast<NoteKind>(m.kind);
  if (kind != NoteKind::kSegmentAbandoned && kind != NoteKind::kSegmentDeleted) return true;
  return 1 <= m.a && m.a <= std::numeric_limits<int>::max() && m.b >= 0;
}

void raise(std::int64_t& count, std::int64_t said) {
  count = std::max(count, said);
}

}  // namespace

void NodeLosses::raise(const NodeLosses& said) {
  roadbalance::raise(repaired, said.repaired);
  roadbalance::raise(spool_failures, said.spool_failures);
  roadbalance::raise(scans_refused, said.scans_refused);
  roadbalance::raise(blocks_unsent, said.blocks_unsent);
  roadbalance::raise(acks_refused, said.acks_refused);
  for (std::size_t line = 0; line < encoder_faults.size(); ++line)
    roadbalance::raise(encoder_faults[line], said.encoder_faults[line]);
  roadbalance::raise(unreferenced_blocks, said.unreferenced_blocks);
  for (std::size_t k = 0; k < device_counts.size(); ++k)
    roadbalance::raise(device_counts[k], said.device_counts[k]);
}

std::vector<std::uint8_t> encode(const Journal& j) {
  wire::journal_t m{};
  m.node = j.node;
  m.epoch = j.epoch;
  m.time_us = j.time_us;
  m.first_sequence = j.first_sequence;
  m.last_sequence = j.last_sequence;
  m.first_scan = j.first_scan;
  m.next_scan = j.next_scan;
  m.scans = j.scans;
  m.scans_missing = j.scans_missing;
  std::copy(j.channel_crc.begin(), j.channel_crc.end(), m.channel_crc);
  put(j.node_losses, m);
  m.refused = j.refused;
  m.rivals = j.rivals;
  m.unsent = j.unsent;
  m.disk_failures = j.disk_failures;
  return wire_format::encode_with_crc(m);
}

std::optional<Journal> decode_journal(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::journal_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  Journal j{.node = m->node,
            .epoch = m->epoch,
            .time_us = m->time_us,
            .first_sequence = m->first_sequence,
            .last_sequence = m->last_sequence,
            .first_scan = m->first_scan,
            .next_scan = m->next_scan,
            .scans = m->scans,
            .scans_missing = m->scans_missing,
            .node_losses = node_losses_of(*m),
            .refused = m->refused,
            .rivals = m->rivals,
            .unsent = m->unsent,
            .disk_failures = m->disk_failures};
  for (std::size_t k = 0; k < j.channel_crc.size(); ++k)
    j.channel_crc[k] = static_cast<std::uint32_t>(m->channel_crc[k]);
  return j;
}

std::vector<std::uint8_t> encode(const Note& n) {
  wire::note_t m{};
  m.time_us = n.time_us;
  m.host_ns = n.host_ns;
  m.incarnation = n.incarnation;
  m.kind = static_cast<std::int32_t>(n.kind);
  m.a = n.a;
  m.b = n.b;
  wire_text::put_text(n.text, m.text, m.size);
  return wire_format::encode_with_crc(m);
}

std::optional<Note> decode_note(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::note_t>(bytes);
  if (!m || m->size < 0 || m->size > static_cast<std::int32_t>(kMaxNoteBytes) ||
      m->kind < static_cast<std::int32_t>(NoteKind::kStarted) ||
      m->kind > static_cast<std::int32_t>(NoteKind::kLast) || !within(m->time_us, kUtcLimit_us) ||
      !within(m->host_ns, kClockLimit_ns) || !is_good_for_its_kind(*m))
    return std::nullopt;
  return Note{.time_us = m->time_us,
              .host_ns = m->host_ns,
              .incarnation = m->incarnation,
              .kind = static_cast<NoteKind>(m->kind),
              .a = m->a,
              .b = m->b,
              .text = wire_text::plain_text(std::string(m->text, m->text + m->size))};
}

std::vector<std::uint8_t> encode(const Commit& commit) {
  wire::commit_t m{};
  m.bytes = commit.bytes;
  m.headers_from = commit.headers_from;
  m.headers_crc32c = static_cast<std::int32_t>(commit.headers_crc32c);
  return wire_format::encode_with_crc(m);
}

std::optional<Commit> decode_commit(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::commit_t>(bytes);
  if (!m || m->bytes < 0 || m->headers_from < 0) return std::nullopt;
  return Commit{.bytes = m->bytes,
                .headers_from = m->headers_from,
                .headers_crc32c = static_cast<std::uint32_t>(m->headers_crc32c)};
}

}  // namespace roadbalance
