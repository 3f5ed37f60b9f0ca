#include "host/recorder/status_line.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "common/bus/absence.hpp"
#include "common/text/format.hpp"

namespace roadbalance {
namespace {

std::string in_words(std::int64_t bytes) {
  constexpr std::array kUnits{"kB", "MB", "GB", "TB"};
  double amount = static_cast<double>(bytes) / 1e3;
  std::size_t unit = 0;
  for (; amount >= 1000.0 && unit + 1 < kUnits.size(); ++unit) amount /= 1000.0;
  std::array<char, 48> text;
  std::snprintf(text.data(), text.size(), amount < 10.0 ? "%.1f %s" : "%.0f %s", amount, kUnits[unit]);
  return text.data();
}

std::string duration(double seconds) {
  std::array<char, 48> text;
  if (seconds >= 2 * 3600.0)
    std::snprintf(text.data(), text.size(), "%.1f h", seconds / 3600.0);
  else
    std::snprintf(text.data(), text.size(), "%.0f min", seconds / 60.0);
  return text.data();
}

constexpr double kSoonFull_s = 3600;
constexpr double kSlowSync_s = 1;

}  // namespace

std::string status_line(const RecorderStatus& status) {
  if (status.state == RecorderState::kIdle) return "waits for a start; no node is there";
  if (status.state == RecorderState::kArmed)
    return "waits for a start; " + std::to_string(status.nodes) +
           (status.nodes == 1 ? " node is" : " nodes are") + " there, " + in_words(status.bytes_free) +
           " free";
  std::string line = status.state == RecorderState::kStopping ? "stops recording" : "records";
  line += " to segment " + std::to_string(status.segment) + ": " + in_words(status.bytes_recorded) +
          " so far, " + in_words(status.bytes_free) + " free";
  if (status.seconds_left >= 0) line += ", " + duration(status.seconds_left) + " left";
  return line;
}

std::vector<RecorderAlarm> alarms(const RecorderStatus& status) {
  std::vector<RecorderAlarm> found;
  const auto add = [&found](AlarmCause cause, std::string text) {
    found.push_back({.cause = cause, .text = std::move(text)});
  };
  const std::string waiting = std::to_string(status.waiting_blocks) + " blocks wait";
  if (status.state == RecorderState::kFault)
    add(AlarmCause::kNothingRecorded,
        "NOTHING IS RECORDED: " + status.fault + "; the nodes keep what they measure");
  else if (!status.fault.empty() && status.state != RecorderState::kDiskFailing)
    add(AlarmCause::kRecorderSays, status.fault);
  if (status.state == RecorderState::kDiskFailing)
    add(AlarmCause::kDiskFailing, "THE DISK FAILS (" + std::to_string(status.disk_failures) +
                                      " times): " + (status.fault.empty() ? "" : status.fault + "; ") +
                                      waiting + ", the nodes keep what they measure");
  if (status.state == RecorderState::kDiskFull)
    add(AlarmCause::kDiskFull,
        "THE DISK IS FULL: " + waiting + ", the nodes keep what they measure; make space");
  for (const AbsentNode& absent : status.absent)
    found.push_back({.cause = AlarmCause::kNodeMissing, .text = words(absent.cause), .node = absent.node});
  if (status.left_out > 0)
    found.push_back({.cause = AlarmCause::kNodeLeftOut,
                     .text = "no more than " + std::to_string(kMostNodes) + " nodes are recorded",
                     .node = status.left_out});
  if (status.rivals > 0)
    add(AlarmCause::kRivals, "two nodes have one number, or one was paused: " +
                                 std::to_string(status.rivals) + " heartbeats; both are recorded");
  if (status.on_battery) add(AlarmCause::kSupplyGone, "the supply is gone: on battery");
  if (status.power_unknown) add(AlarmCause::kSupplyUnknown, "whether the supply is there cannot be read");
  if (status.fallback) add(AlarmCause::kFallback, "records to the fallback folder");
  const bool is_full = status.state == RecorderState::kDiskFull;
  if (!is_full && status.seconds_left >= 0 && status.seconds_left < kSoonFull_s)
    add(AlarmCause::kDiskLow, "the disk is full in " + duration(status.seconds_left));
  if (status.sync_s >= kSlowSync_s)
    add(AlarmCause::kDiskSlow, format("the disk is slow: its last sync took %.0f s", status.sync_s));
  if (status.unsent > 0)
    add(AlarmCause::kUnsent,
        std::to_string(status.unsent) + " datagrams could not be sent: is the network up?");
  // Within a level the order is the one above.
  std::ranges::stable_sort(found, std::ranges::greater{},
                           [](const RecorderAlarm& alarm) { return level_of(alarm.cause); });
  return found;
}

std::string words(const RecorderAlarm& alarm) {
  if (alarm.node == 0) return alarm.text;
  return place_of({alarm.cause, alarm.node}) + " " + name_of(alarm.cause) + ": " + alarm.text;
}

}  // namespace roadbalance
