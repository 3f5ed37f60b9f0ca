#include "host/recorder/write_batch.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::seconds kCounters{1};

}  // namespace

WriteBatch BatchMaker::take(RecorderLink& link, WallTime now) {
  WriteBatch batch{.deliveries = link.deliveries(), .device_notes = link.device_notes()};
  if (now - counted_at_ >= kCounters) {
    counted_at_ = now;
    batch.counters = link.counters();
  }
  return batch;
}

WriteBatch BatchMaker::take_last(RecorderLink& link) {
  WriteBatch batch{.deliveries = link.deliveries(), .device_notes = link.device_notes()};
  if (batch.says_something()) batch.counters = link.counters();
  return batch;
}

void append(RecordKeeper& keeper, const WriteBatch& batch, WallTime now) {
  if (batch.counters) keeper.set_link_counters(*batch.counters);
  for (const Delivery& delivery : batch.deliveries) keeper.append(delivery, now);
  for (const DeviceNote& device : batch.device_notes)
    keeper.note(NoteKind::kDevice, device.node, static_cast<std::int64_t>(device.counter), device.text);
  for (const AlarmNote& note : batch.alarm_notes)
    keeper.note(note.began ? NoteKind::kAlarmBegan : NoteKind::kAlarmEnded,
                static_cast<std::int64_t>(note.alarm.cause), place_number(note.alarm), note.text);
}

}  // namespace roadbalance
