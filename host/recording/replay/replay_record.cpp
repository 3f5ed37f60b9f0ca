#include "host/recording/replay/replay_record.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <thread>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/frontend/pace.hpp"
#include "common/record/record_reader.hpp"
#include "host/recording/subset/epoch_clocks.hpp"

namespace roadbalance {
namespace {

/// A longer wait is split, to notice a stop request in between.
constexpr std::chrono::milliseconds kLongestWait{100};

class DriveTime {
 public:
  explicit DriveTime(const RecordingSurvey& survey) : clocks_(survey) {
    begin_ns_ = std::numeric_limits<std::int64_t>::max();
    for (const RecordedSpan& span : survey.span)
      if (span.first_fit || !survey.own_clocks()) {
        begin_ns_ = std::min(begin_ns_, span.first_host_ns());
        end_ns_ = std::max(end_ns_, span.end_ns());
      }
  }

  /// The time of an event, in seconds since the first sample; it never steps back.
  double of(const LogEvent& event) {
    clocks_.take(event);
    if (event.channel.starts_with(kBlockChannels) && accept(event, *block_) == Refusal::kNone &&
        block_->kind == BlockKind::kScan) {
      const NodeEpoch key{block_->header.node, block_->header.epoch};
      const EpochClock* clock = clocks_.of(key);
      // A block is sealed with its last scan.
      const auto end_ns =
          block_->header.time_ns + block_->header.scans * summary_of(*block_).period_ps / 1000;
      if (const auto time_ns = clock ? clock->time_ns(end_ns) : std::nullopt)
        now_s_ = std::max(now_s_, 1e-9 * static_cast<double>(*time_ns - begin_ns_));
    }
    return now_s_;
  }
  double all_s() const { return 1e-9 * static_cast<double>(end_ns_ - begin_ns_); }

 private:
  EpochClocks clocks_;
  std::int64_t begin_ns_ = 0;
  std::int64_t end_ns_ = std::numeric_limits<std::int64_t>::min();
  double now_s_ = 0.0;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
};

/// False: stop was requested before.
bool wait_until(WallTime due, const std::stop_token& stop) {
  for (auto now = WallClock::now(); now < due; now = WallClock::now()) {
    if (stop.stop_requested()) return false;
    std::this_thread::sleep_until(std::min(due, now + kLongestWait));
  }
  return true;
}

}  // namespace

ReplayReport replay_record(const std::filesystem::path& folder, const RecordingSurvey& survey,
                           const std::optional<double>& speed, const Publish& publish,
                           const std::stop_token& stop, const ReplayProgress& progress) {
  RecordReader reader(folder);
  reader.finish();
  DriveTime time(survey);
  ReplayReport report;
  std::optional<Pace> pace;
  double square_s2 = 0.0;
  std::int64_t waited = 0;
  while (const auto event = reader.next()) {
    if (stop.stop_requested()) break;
    report.drive_s = time.of(*event);
    if (speed && !pace) pace.emplace(*speed, WallClock::now());
    if (pace) {
      const WallTime due = pace->wall(report.drive_s);
      if (WallClock::now() < due) {
        if (!wait_until(due, stop)) break;
        const double late_s = std::chrono::duration<double>(WallClock::now() - due).count();
        report.late_most_s = std::max(report.late_most_s, late_s);
        square_s2 += late_s * late_s;
        ++waited;
      }
    }
    ++report.events;
    report.bytes += event->data.size();
    if (!publish(std::string(event->channel), event->data)) ++report.unsent;
    if (progress) progress(report.drive_s, time.all_s());
  }
  if (waited > 0) report.late_rms_s = std::sqrt(square_s2 / static_cast<double>(waited));
  return report;
}

}  // namespace roadbalance
