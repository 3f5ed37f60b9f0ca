#include "host/recorder/alarm_watch.hpp"

#include <algorithm>
#include <cmath>

#include "common/bus/channel_faults.hpp"
#include "host/recorder/status_line.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::duration<double> kClockPatience{kClockPatience_s};
constexpr std::size_t kMostWatched = 64;

std::string in_us(double seconds) {
  return std::to_string(std::llround(std::ceil(1e6 * std::clamp(seconds, 0.0, 1e3)))) + " us";
}

}  // namespace

/// For counters that begin anew with each epoch and only rise in it.
void AlarmWatch::rise(const Alarm& alarm, std::int64_t epoch, std::int64_t count, const char* what,
                      WallTime now) {
  auto& [of_epoch, known] = counted_[alarm];
  if (of_epoch != epoch) known = 0;
  of_epoch = epoch;
  if (count <= known) return;  // a late one, too
  known = count;
  std::string text = std::to_string(count) + what;
  if (count == 1) text.pop_back();  // its plural
  log_.raise(alarm, text + " by now", now);
}

void AlarmWatch::take(const Heartbeat& beat, WallTime now) {
  if (owner_ != 0 && beat.owner != owner_) {
    // It is heard, and another recorder's to miss.
    if (const auto known = node_.find(beat.node); known != node_.end()) known->second.measures = false;
    return;
  }
  if (!node_.contains(beat.node) && node_.size() >= kMostWatched) return;
  Node& node = node_[beat.node];
  node.measures = beat.state == NodeState::kStarted;
  const bool wants = node.measures && beat.time_base == TimeBase::kOwn && beat.owner != 0;
  if (wants && (!node.wants_clock || node.epoch != beat.epoch)) {
    node.clock_since = node.clock_heard = now;
    node.clock_exchanges = 0;
    node.was_well_known = false;
  }
  node.wants_clock = wants;
  node.epoch = beat.epoch;
  node.heard = now;
  const auto of = [&](AlarmCause cause, std::int32_t part = -1) { return Alarm{cause, beat.node, part}; };
  rise(of(AlarmCause::kSamplesLost), beat.epoch, beat.scans_missing + beat.scans_refused, " samples", now);
  for (std::size_t line = 0; line < beat.encoder_faults.size(); ++line)
    rise(of(AlarmCause::kFaultyTurns, static_cast<std::int32_t>(line)), beat.epoch, beat.encoder_faults[line],
         " turns", now);
  for (std::size_t line = 0; line < beat.encoder_faults.size(); ++line)
    if (const auto counts = std::span(beat.mark_counts).subspan(2 * line).first<2>(); counts[0] > 0)
      log_.raise(of(AlarmCause::kWrongMarks, static_cast<std::int32_t>(line)), wrong_marks(counts), now);
  rise(of(AlarmCause::kSpoolFailing), beat.epoch, beat.spool_failures, " failures", now);
  const auto counted = [&beat](DeviceCounter counter) {
    return beat.device_counts[static_cast<std::size_t>(counter)];
  };
  if (counted(DeviceCounter::kGone) > counted(DeviceCounter::kReturned))
    log_.raise(of(AlarmCause::kDeviceGone), "look at its cable and supply", now);
  if (beat.state == NodeState::kFailed) log_.raise(of(AlarmCause::kNodeFailed), "", now);
}

void AlarmWatch::take_channels(const Level& level, WallTime now) {
  for (std::size_t c = 0; c < kChannels; ++c) {
    const auto of = [&](AlarmCause cause) { return Alarm{cause, level.node, static_cast<std::int32_t>(c)}; };
    if ((level.overload >> c & 1U) != 0) log_.raise(of(AlarmCause::kOverload), "", now);
    if (is_clipped(level, c)) log_.raise(of(AlarmCause::kClipped), "choose a larger range", now);
    if (is_dead(level, c)) log_.raise(of(AlarmCause::kDeadChannel), "", now);
    if (is_railed(level, c)) log_.raise(of(AlarmCause::kRailedChannel), "", now);
  }
}

void AlarmWatch::take(const Level& level, WallTime now) {
  if (!is_watched(level.node)) return;
  analyser_spoke_ = true;
  analyser_heard_ = now;
  take_channels(level, now);
}

void AlarmWatch::take(const ClockFit& fit, WallTime now) {
  const auto known = node_.find(fit.node);
  if (known == node_.end()) return;
  rise({AlarmCause::kClockBroken, fit.node}, fit.epoch, fit.breaks, " breaks", now);
  if (fit.state == ClockState::kHoldover) log_.raise({AlarmCause::kClockUnheard, fit.node}, "", now);
  Node& node = known->second;
  if (fit.epoch != node.epoch) return;
  if (fit.exchanges > node.clock_exchanges) node.clock_answered = now;
  node.clock_exchanges = fit.exchanges;
  if (fit.state != ClockState::kLocked) return;
  node.clock_heard = now;
  if (fit.uncertainty_s <= kWantedSync_s)
    node.was_well_known = true;
  else if (node.wants_clock && (node.was_well_known || now - node.clock_since >= kClockPatience))
    log_.raise({AlarmCause::kClockPoor, fit.node},
               in_us(fit.uncertainty_s) + ", " + in_us(kWantedSync_s) + " are wanted", now);
}

void AlarmWatch::take(const Balance& wheel, WallTime now) {
  if (node_.empty() || wheel.state != Unknown::kInStep) return;
  log_.raise({AlarmCause::kWheelInStep, 0, wheel.wheel}, "change lane or take a bend", now);
}

void AlarmWatch::take(const RecorderStatus& status, WallTime now) {
  for (const RecorderAlarm& alarm : alarms(status)) log_.raise({alarm.cause, alarm.node}, alarm.text, now);
}

void AlarmWatch::take_other_version(std::int32_t node, WallTime now) {
  log_.raise({AlarmCause::kOtherVersion, node}, "install the same release everywhere", now);
}

// A node that is silent itself is another matter.
void AlarmWatch::miss_clock(std::int32_t number, const Node& node, WallTime now) {
  if (!node.wants_clock || now - node.clock_heard < kClockPatience) return;
  const bool answers = node.clock_exchanges > 0 && now - node.clock_answered < kClockPatience;
  log_.raise({AlarmCause::kClockUnheard, number},
             answers ? "it answers, too rarely to be known: look at its network" : "look at its network",
             now);
}

void AlarmWatch::turn(WallTime now) {
  bool anybody = false;
  for (const auto& [number, node] : node_) {
    if (!node.measures) continue;
    if (now - node.heard >= kSilence) {
      log_.raise({AlarmCause::kNodeSilent, number}, "look at its cable and supply", now);
    } else {
      anybody = true;
      miss_clock(number, node, now);
    }
  }
  if (!anybody) nobody_measured_ = now;
  if (anybody && analyser_spoke_ && now - std::max(analyser_heard_, nobody_measured_) >= kSilence)
    log_.raise({AlarmCause::kAnalyserSilent}, "levels and balance are old", now);
}

}  // namespace roadbalance
