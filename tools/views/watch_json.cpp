#include "tools/views/watch_json.hpp"

#include "host/recorder/status_line.hpp"
#include "tools/views/alarm_lines.hpp"
#include "tools/views/compensation_json.hpp"
#include "tools/views/order_lines.hpp"
#include "tools/views/weight_check_line.hpp"
#include "tools/views/wheels_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

const char* name_of(RecorderState state) {
  switch (state) {
    case RecorderState::kRecording:
      return "recording";
    case RecorderState::kDiskFailing:
      return "disk_failing";
    case RecorderState::kDiskFull:
      return "disk_full";
    case RecorderState::kStopping:
      return "stopping";
    case RecorderState::kIdle:
      return "idle";
    case RecorderState::kArmed:
      return "armed";
    case RecorderState::kFault:
      return "fault";
  }
  return "unknown";
}

const char* name_of(NodeState state) {
  switch (state) {
    case NodeState::kPreview:
      return "preview";
    case NodeState::kStarted:
      return "started";
    case NodeState::kEnded:
      return "ended";
    case NodeState::kFailed:
      return "failed";
  }
  return "unknown";
}

const char* name_of(ClockState state) {
  switch (state) {
    case ClockState::kAcquire:
      return "acquire";
    case ClockState::kLocked:
      return "locked";
    case ClockState::kHoldover:
      return "holdover";
  }
  return "unknown";
}

Json if_known(bool is_known, double value) {
  return is_known ? Json(value) : Json(nullptr);
}

// Those that are not zero.
Json device_counts(const Heartbeat& beat) {
  Json counts = Json::object();
  for (std::size_t k = 0; k < kDeviceCounters; ++k)
    if (beat.device_counts[k] != 0)
      counts[roadbalance::name_of(static_cast<DeviceCounter>(k))] = beat.device_counts[k];
  return counts;
}

std::array<Balance, kWheels> balance_of(const BusView& view) {
  std::array<Balance, kWheels> balance;
  for (std::size_t w = 0; w < kWheels; ++w) balance[w] = view.balance()[w].value_or(Balance{});
  return balance;
}

Json wheels(const BusView& view) {
  if (!view.identification()) return nullptr;
  return wheels_json(*view.identification(), balance_of(view));
}

Json compensation(const BusView& view) {
  if (!view.identification()) return nullptr;
  std::array<Compensation, kWheels> compensation;
  for (std::size_t w = 0; w < kWheels; ++w) compensation[w] = view.compensation(w);
  return compensation_json(balance_of(view), compensation);
}

Json own_alarms(const RecorderStatus& status) {
  Json found = Json::array();
  for (const RecorderAlarm& alarm : alarms(status))
    found.push_back(alarm_json({alarm.cause, alarm.node}, alarm.text));
  return found;
}

Json active_alarms(const BusView& view) {
  Json found = Json::array();
  for (const ActiveAlarm& on : view.alarms()) found.push_back(alarm_json(on.alarm, on.text));
  return found;
}

}  // namespace

Json recorder_json(const RecorderStatus& status) {
  return {{"recorder", status.recorder},
          {"recording", status.name},
          {"recording_s", status.recording_s},
          {"incarnation", status.incarnation},
          {"state", name_of(status.state)},
          {"segment", status.segment},
          {"bytes_recorded", status.bytes_recorded},
          {"bytes_free", status.bytes_free},
          {"seconds_left", if_known(status.seconds_left >= 0, status.seconds_left)},
          {"longest_sync_s", status.longest_sync_s},
          {"waiting_blocks", status.waiting_blocks},
          {"disk_failures", status.disk_failures},
          {"alarms", own_alarms(status)}};
}

Json node_json(const Heartbeat& beat, std::optional<double> memory_left_s) {
  return {{"node", beat.node},
          {"epoch", beat.epoch},
          {"state", name_of(beat.state)},
          {"owner", beat.owner > 0 ? Json(beat.owner) : Json(nullptr)},
          {"samples", beat.scans_sampled},
          {"samples_missing", beat.scans_missing},
          {"blocks_held", beat.ring_used},
          {"blocks_that_fit", beat.ring_capacity},
          {"blocks_on_disk", beat.spool_used},
          {"disk_failures", beat.spool_failures},
          {"memory_left_s", if_known(memory_left_s.has_value(), memory_left_s.value_or(0.0))},
          {"blocks_repaired", beat.blocks_repaired},
          {"faulty_turns", beat.encoder_faults},
          {"mark_counts", beat.mark_counts},
          {"blocks_without_angle", beat.unreferenced_blocks},
          {"devices", device_counts(beat)}};
}

Json clock_json(const ClockFit& fit) {
  const bool is_known = fit.is_known();
  return {{"node", fit.node},
          {"epoch", fit.epoch},
          {"state", name_of(fit.state)},
          {"drift", if_known(is_known, fit.drift)},
          {"uncertainty_s", if_known(is_known, fit.uncertainty_s)},
          {"round_trip_s", if_known(is_known, fit.round_trip_s)},
          {"exchanges", fit.exchanges},
          {"unanswered", fit.unanswered},
          {"breaks", fit.breaks}};
}

Json watch_json(const BusView& view) {
  Json recorders = Json::array(), nodes = Json::array(), clocks = Json::array();
  for (const auto& [incarnation, status] : view.recorders()) recorders.push_back(recorder_json(status));
  for (const auto& [node, beat] : view.heartbeats())
    nodes.push_back(node_json(beat, view.memory_left_s(node)));
  for (const auto& [node, fit] : view.clocks()) clocks.push_back(clock_json(fit));
  Json orders = Json::array();
  for (const auto& [key, report] : view.orders()) orders.push_back(order_report_json(report));
  Json weight_check = Json::array();
  for (const auto& wheel : view.weight_check())
    if (wheel) weight_check.push_back(weight_check_json(*wheel));
  return {{"wheels", wheels(view)},
          {"compensation", compensation(view)},
          {"remarks", view.remarks()},
          {"verification", weight_check},
          {"recorders", recorders},
          {"nodes", nodes},
          {"clocks", clocks},
          {"orders", orders},
          {"alarms", active_alarms(view)}};
}

}  // namespace roadbalance
