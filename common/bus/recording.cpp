#include "common/bus/recording.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <wire/recording_t.hpp>

#include "common/bus/wire_format.hpp"
#include "common/bus/wire_text.hpp"

namespace roadbalance {
namespace {

static_assert(sizeof(wire::recording_t::node) / sizeof(std::int32_t) == kMostReceiptNodes);
static_assert(sizeof(wire::recording_t::mark_us) / sizeof(std::int64_t) == kMostReceiptMarks);

bool in_bounds(const wire::recording_t& m) {
  return 0 <= m.recordings && m.recordings <= kMostRecordings && 0 <= m.number &&
         m.number < std::max(m.recordings, 1) && 0 <= m.state &&
         m.state <= static_cast<std::int32_t>(RecordingState::kUnreadable) && 0 <= m.nodes &&
         m.nodes <= static_cast<std::int32_t>(kMostReceiptNodes) && 0 <= m.marks && 0 <= m.most_reduction &&
         m.rate_hz >= 0.0 && std::isfinite(m.rate_hz) && m.cutoff_hz >= 0.0 && std::isfinite(m.cutoff_hz);
}

}  // namespace

std::vector<std::uint8_t> encode(const RecordingReceipt& r) {
  wire::recording_t m{};
  m.number = r.number;
  m.recordings = r.recordings;
  wire_text::put_text(r.name, m.name);
  wire_text::put_text(r.place, m.place);
  wire_text::put_text(r.vehicle, m.vehicle);
  m.state = static_cast<std::int32_t>(r.state);
  m.first_us = r.first_us;
  m.last_us = r.last_us;
  m.bytes = r.bytes;
  m.refused = r.refused;
  m.damaged_bytes = r.damaged_bytes;
  m.rate_hz = r.rate_hz;
  m.cutoff_hz = r.cutoff_hz;
  m.most_reduction = r.most_reduction;
  m.nodes = static_cast<std::int32_t>(std::min(r.node.size(), kMostReceiptNodes));
  for (std::int32_t k = 0; k < m.nodes; ++k) {
    const auto& node = r.node[static_cast<std::size_t>(k)];
    m.node[k] = node.node;
    m.samples[k] = node.samples;
    m.samples_lost[k] = node.samples_lost;
    m.repaired[k] = node.repaired;
    m.seconds[k] = node.seconds;
    m.overload_s[k] = node.overload_s;
    m.sync_residual_s[k] = node.sync_residual_s;
  }
  m.marks = r.marks;
  for (std::size_t k = 0; k < std::min(r.mark.size(), kMostReceiptMarks); ++k) {
    m.mark_number[k] = r.mark[k].number;
    m.mark_us[k] = r.mark[k].time_us;
    wire_text::put_text(r.mark[k].text, m.mark[k]);
  }
  wire_text::put_text(r.verdict, m.verdict, m.size);
  return wire_format::encode(m);
}

std::optional<RecordingReceipt> decode_recording(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::recording_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  auto verdict = wire_text::text_of(m->verdict, m->size);
  if (!verdict) return std::nullopt;
  RecordingReceipt r;
  r.number = m->number;
  r.recordings = m->recordings;
  r.name = wire_text::text_until_zero(m->name);
  r.place = wire_text::text_until_zero(m->place);
  r.vehicle = wire_text::text_until_zero(m->vehicle);
  r.state = static_cast<RecordingState>(m->state);
  r.first_us = m->first_us;
  r.last_us = m->last_us;
  r.bytes = m->bytes;
  r.refused = m->refused;
  r.damaged_bytes = m->damaged_bytes;
  r.rate_hz = m->rate_hz;
  r.cutoff_hz = m->cutoff_hz;
  r.most_reduction = m->most_reduction;
  for (std::int32_t k = 0; k < m->nodes; ++k)
    r.node.push_back({m->node[k], m->samples[k], m->samples_lost[k], m->repaired[k], m->seconds[k],
                      m->overload_s[k], m->sync_residual_s[k]});
  r.marks = m->marks;
  for (std::int32_t k = 0; k < std::min(m->marks, static_cast<std::int32_t>(kMostReceiptMarks)); ++k)
    r.mark.push_back({m->mark_us[k], wire_text::text_until_zero(m->mark[k]), m->mark_number[k]});
  r.verdict = std::move(*verdict);
  return r;
}

}  // namespace roadbalance
