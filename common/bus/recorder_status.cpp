#include "common/bus/recorder_status.hpp"

#include <algorithm>
#include <cmath>
#include <wire/recorder_t.hpp>

#include "common/bus/wire_format.hpp"
#include "common/bus/wire_text.hpp"

namespace roadbalance {
namespace {

constexpr std::int32_t kOnBattery = 1;  // bits of on_battery
constexpr std::int32_t kPowerUnknown = 2;

}  // namespace

std::vector<std::uint8_t> encode(const RecorderStatus& s) {
  wire::recorder_t m{};
  m.time_us = s.time_us;
  m.recorder = s.recorder;
  m.incarnation = s.incarnation;
  m.state = static_cast<std::int32_t>(s.state);
  m.on_battery = (s.on_battery ? kOnBattery : 0) | (s.power_unknown ? kPowerUnknown : 0);
  m.fallback = s.fallback ? 1 : 0;
  m.segment = s.segment;
  m.bytes_recorded = s.bytes_recorded;
  m.bytes_free = s.bytes_free;
  m.seconds_left = s.seconds_left;
  m.sync_s = s.sync_s;
  m.longest_sync_s = s.longest_sync_s;
  m.waiting_blocks = s.waiting_blocks;
  m.disk_failures = s.disk_failures;
  m.segments_deleted = s.segments_deleted;
  m.refused_datagrams = s.refused_datagrams;
  std::copy(s.refused_blocks.begin(), s.refused_blocks.end(), m.refused_blocks);
  m.rivals = s.rivals;
  m.unsent = s.unsent;
  m.recording_s = s.recording_s;
  m.nodes = s.nodes;
  m.marks = s.marks;
  m.operable = s.operable ? 1 : 0;
  wire_text::put_text(s.name, m.name, m.name_size);
  wire_text::put_text(s.fault, m.fault, m.fault_size);
  return wire_format::encode_with_crc(m);
}

std::optional<RecorderStatus> decode_recorder_status(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::recorder_t>(bytes);
  if (!m || m->state < static_cast<std::int32_t>(RecorderState::kRecording) ||
      m->state > static_cast<std::int32_t>(RecorderState::kFault) || !std::isfinite(m->recording_s) ||
      !std::isfinite(m->seconds_left) || !std::isfinite(m->sync_s) || !std::isfinite(m->longest_sync_s))
    return std::nullopt;
  const auto name = wire_text::text_of(m->name, m->name_size);
  const auto fault = wire_text::text_of(m->fault, m->fault_size);
  if (!name || !fault) return std::nullopt;
  RecorderStatus s{.time_us = m->time_us,
                   .recorder = m->recorder,
                   .incarnation = m->incarnation,
                   .state = static_cast<RecorderState>(m->state),
                   .on_battery = (m->on_battery & kOnBattery) != 0,
                   .power_unknown = (m->on_battery & kPowerUnknown) != 0,
                   .fallback = m->fallback != 0,
                   .segment = m->segment,
                   .bytes_recorded = m->bytes_recorded,
                   .bytes_free = m->bytes_free,
                   .seconds_left = m->seconds_left,
                   .sync_s = m->sync_s,
                   .longest_sync_s = m->longest_sync_s,
                   .waiting_blocks = m->waiting_blocks,
                   .disk_failures = m->disk_failures,
                   .segments_deleted = m->segments_deleted,
                   .refused_datagrams = m->refused_datagrams,
                   .rivals = m->rivals,
                   .unsent = m->unsent,
                   .recording_s = m->recording_s,
                   .nodes = m->nodes,
                   .marks = m->marks,
                   .operable = m->operable != 0,
                   .name = *name,
                   .fault = *fault};
  std::copy(std::begin(m->refused_blocks), std::end(m->refused_blocks), s.refused_blocks.begin());
  return s;
}

}  // namespace roadbalance
