#include "host/recorder/write_batch.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::seconds kCounters{1};

WriteBatch take_news(RecorderLink& link) {
  return {.deliveries = link.deliveries(), .device_notes = link.device_notes(), .notes = link.notes()};
}

}  // namespace

WriteBatch BatchMaker::take(RecorderLink& link, WallTime now) {
  WriteBatch batch = take_news(link);
  if (now - counted_at_ >= kCounters) {
    counted_at_ = now;
    batch.counters = link.counters();
  }
  return batch;
}

WriteBatch BatchMaker::take_last(RecorderLink& link) {
  WriteBatch batch = take_news(link);
  if (batch.has_content()) batch.counters = link.counters();
  return batch;
}

void append(RecordingStore& store, const WriteBatch& batch, WallTime now) {
  if (batch.counters) store.set_link_counters(*batch.counters);
  for (const Delivery& delivery : batch.deliveries) store.append(delivery, now);
  for (const DeviceNote& device : batch.device_notes)
    store.note(NoteKind::kDevice, device.node, static_cast<std::int64_t>(device.counter), device.text);
  for (const NoteToRecord& note : batch.notes)
    store.note(note.kind, note.a, note.b, note.text, now - note.at);
  for (const AlarmNote& note : batch.alarm_notes)
    store.note(note.began ? NoteKind::kAlarmBegan : NoteKind::kAlarmEnded,
               static_cast<std::int64_t>(note.alarm.cause), place_number(note.alarm), note.text);
}

}  // namespace roadbalance
