#include "common/bus/recorder_status.hpp"

#include <wire/recorder_t.hpp>

#include "common/bus/fields.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<RecorderStatus> {
  using Wire = wire::recorder_t;
  static void list(auto& field, auto& s, auto& m) {
    field(s.time_us, m.time_us);
    field(s.recorder, m.recorder);
    field(s.incarnation, m.incarnation);
    field(s.state, m.state, within(RecorderState::kRecording, RecorderState::kFault));
    field.bit(s.on_battery, m.on_battery, 0);
    field.bit(s.power_unknown, m.on_battery, 1);
    field(s.fallback, m.fallback);
    field(s.segment, m.segment);
    field(s.bytes_recorded, m.bytes_recorded);
    field(s.bytes_free, m.bytes_free);
    field(s.seconds_left, m.seconds_left, is_finite);
    field(s.sync_s, m.sync_s, is_finite);
    field(s.longest_sync_s, m.longest_sync_s, is_finite);
    field(s.waiting_blocks, m.waiting_blocks);
    field(s.disk_failures, m.disk_failures);
    field(s.segments_deleted, m.segments_deleted);
    field(s.refused_datagrams, m.refused_datagrams);
    field(s.refused_blocks, m.refused_blocks);
    field(s.rivals, m.rivals);
    field(s.unsent, m.unsent);
    field(s.recording_s, m.recording_s, is_finite);
    field(s.nodes, m.nodes);
    field(s.marks, m.marks);
    field.first_rows(s.absent, m.absent, kMostAbsentNamed, [&](auto& absent, std::size_t k) {
      field(absent.node, m.absent_node[k], is_node);
      field(absent.cause, m.absent_cause[k], within(AbsenceCause::kStopped, AbsenceCause::kNeverCame));
    });
    field(s.left_out, m.left_out, up_to(kLastNode));
    field(s.operable, m.operable);
    field.text(s.name, m.name, m.name_size);
    field.text(s.fault, m.fault, m.fault_size);
  }
};

}  // namespace wire_fields

std::vector<std::uint8_t> encode(const RecorderStatus& status) {
  return wire_fields::encode(status);
}

std::optional<RecorderStatus> decode_recorder_status(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<RecorderStatus>(bytes);
}

}  // namespace roadbalance
