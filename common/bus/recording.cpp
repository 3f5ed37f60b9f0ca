#include "common/bus/recording.hpp"

#include <algorithm>
#include <wire/recording_t.hpp>

#include "common/bus/fields.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<RecordingSummary> {
  using Wire = wire::recording_t;
  static void list(auto& field, auto& r, auto& m) {
    field(r.recordings, m.recordings, up_to(kMostRecordings));
    field(r.number, m.number, below(std::max(m.recordings, 1)));
    field.text(r.name, m.name);
    field.text(r.place, m.place);
    field.text(r.vehicle, m.vehicle);
    field(r.state, m.state, up_to(RecordingState::kUnreadable));
    field(r.first_us, m.first_us);
    field(r.last_us, m.last_us);
    field(r.bytes, m.bytes);
    field(r.refused, m.refused);
    field(r.damaged_bytes, m.damaged_bytes);
    field(r.rate_hz, m.rate_hz, is_size);
    field(r.cutoff_hz, m.cutoff_hz, is_size);
    field(r.most_reduction, m.most_reduction, at_least(0));
    field.first_rows(r.node, m.nodes, kMostReceiptNodes, [&](auto& node, std::size_t k) {
      field(node.node, m.node[k]);
      field(node.samples, m.samples[k]);
      field(node.samples_lost, m.samples_lost[k]);
      field(node.absent, m.absent[k]);
      field(node.repaired, m.repaired[k]);
      field(node.seconds, m.seconds[k]);
      field(node.overload_s, m.overload_s[k]);
      field(node.sync_residual_s, m.sync_residual_s[k]);
    });
    field(r.marks, m.marks, at_least(0));
    auto told = std::min(m.marks, static_cast<std::int32_t>(kMostReceiptMarks));
    field.first_rows(r.mark, told, kMostReceiptMarks, [&](auto& mark, std::size_t k) {
      field(mark.number, m.mark_number[k]);
      field(mark.time_us, m.mark_us[k]);
      field.text(mark.text, m.mark[k]);
    });
    field.text(r.verdict, m.verdict, m.size);
  }
};

}  // namespace wire_fields

static_assert(sizeof(wire::recording_t::node) / sizeof(std::int32_t) == kMostReceiptNodes);
static_assert(sizeof(wire::recording_t::mark_us) / sizeof(std::int64_t) == kMostReceiptMarks);

std::vector<std::uint8_t> encode(const RecordingSummary& receipt) {
  return wire_fields::encode(receipt);
}

std::optional<RecordingSummary> decode_recording(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<RecordingSummary>(bytes);
}

}  // namespace roadbalance
