#include <algorithm>

#include "common/bus/recorder_status.hpp"
#include "host/recorder/operating.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kStatus{500};
constexpr std::chrono::milliseconds kReceipts{1000};

}  // namespace

// From its first word to its end the session says the state itself, with what it knows.
void Operating::say_status(const Publish& publish) {
  if (time_.now - status_at_ < kStatus || session_speaks()) return;
  status_at_ = time_.now;
  RecorderStatus status{
      .time_us = time_.utc_us, .recorder = recorder_, .nodes = heard_.count(time_.now), .operable = true};
  status.state = status.nodes > 0 ? RecorderState::kArmed : RecorderState::kIdle;
  if (const auto& recording = desk_.under_way()) {
    status.state = desk_.fault().empty() ? RecorderState::kRecording : RecorderState::kFault;
    status.name = recording->name;
    status.recording_s = 1e-6 * static_cast<double>(status.time_us - recording->began_us);
    status.marks = recording->durable_marks;
  }
  status.fault = desk_.fault();
  const std::int64_t free = world_.disk.free_bytes(options_.recordings.c_str());
  status.bytes_free = std::max<std::int64_t>(0, free - options_.recorder.reserve_bytes);
  if (set_up_ && !desk_.under_way()) {
    status.seconds_left = static_cast<double>(status.bytes_free) / set_up_->bytes_per_s();
    if (status.fault.empty()) status.fault = who_differs();
  }
  if (free >= 0 && status.bytes_free == 0 && !desk_.under_way()) status.state = RecorderState::kDiskFull;
  (void)publish(kRecorderChannel, encode(status));
  if (options_.recorder.on_alive) options_.recorder.on_alive(status);
}

void Operating::say_receipts(const Publish& publish) {
  if (time_.now - receipts_at_ < kReceipts) return;
  receipts_at_ = time_.now;
  if (!desk_.finished() || desk_.under_way()) return;
  for (const Receipt& receipt : desk_.finished()->receipt) (void)publish(kReceiptChannel, encode(receipt));
}

}  // namespace roadbalance
