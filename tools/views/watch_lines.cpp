#include "tools/views/watch_lines.hpp"

#include <cstdio>

#include "host/recorder/status_line.hpp"
#include "tools/views/alarm_lines.hpp"
#include "tools/views/clock_line.hpp"
#include "tools/views/order_lines.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/weight_check_line.hpp"

namespace roadbalance {
namespace {

void add_levels(const BusView& view, std::vector<std::string>& lines) {
  for (const auto& [node, level] : view.levels()) {
    auto node_lines = level_lines(level);
    for (std::int32_t c = 0; c < kAccelerations; ++c)
      if (const auto line = view.highest_lines().find({node, c}); line != view.highest_lines().end())
        if (line->second.density > 0.0) {
          char text[64];
          std::snprintf(text, sizeof text, "  strongest at %.1f Hz", line->second.frequency_hz);
          node_lines[static_cast<std::size_t>(c) + 1] += text;
        }
    lines.insert(lines.end(), node_lines.begin(), node_lines.end());
  }
}

}  // namespace

std::vector<std::string> recorder_lines(const RecorderStatus& status,
                                        const std::map<std::int32_t, Heartbeat>& beats) {
  const bool records = status.incarnation != 0;
  std::vector<std::string> lines{(records ? "recorder " + std::to_string(status.incarnation) : "recorder") +
                                 ": " + status_line(status)};
  for (const auto& alarm : alarms(status))
    lines.push_back("  " + alarm_line(level_of(alarm.cause), words(alarm)));
  if (!records) return lines;
  for (const auto& [node, beat] : beats)
    if (beat.owner == status.incarnation) return lines;
  for (const auto& [node, beat] : beats)
    if (beat.owner > 0 && !beat.is_over())
      lines.push_back("  ! records nothing of node " + std::to_string(node) + ", which obeys recorder " +
                      std::to_string(beat.owner));
  return lines;
}

std::vector<std::string> watch_lines(const BusView& view) {
  std::vector<std::string> lines;
  const auto add = [&lines](const std::vector<std::string>& more) {
    lines.insert(lines.end(), more.begin(), more.end());
  };
  add(alarm_lines(view.alarms()));
  if (view.identification()) lines.push_back(identification_line(*view.identification()));
  for (std::size_t w = 0; w < kWheels; ++w) {
    const auto& balance = view.balance()[w];
    if (!balance) continue;
    lines.push_back(balance_line(*balance));
    add(advice_lines(*balance, view.compensation(w)));
    if (const auto& check = view.weight_check()[w]) lines.push_back("  " + weight_check_line(*check));
  }
  for (const std::string& remark : view.remarks()) lines.push_back("  * " + remark);
  for (const auto& [incarnation, status] : view.recorders()) add(recorder_lines(status, view.heartbeats()));
  if (view.recorders().size() > 1)
    lines.push_back("  ! more than one recorder: a node obeys only one of them");
  for (const auto& [node, heartbeat] : view.heartbeats()) {
    lines.push_back(node_line(heartbeat, view.memory_left_s(node)));
    if (const std::string devices = device_line(heartbeat); !devices.empty())
      lines.push_back("  ! " + devices);
    if (const auto fit = view.clocks().find(node); fit != view.clocks().end())
      lines.push_back("  " + clock_line(fit->second));
  }
  for (int wheel = 0; wheel < kWheels; ++wheel) add(strongest_order_lines(view.orders(), wheel));
  add_levels(view, lines);
  if (lines.empty()) lines.push_back("waiting for an analyser on the bus");
  return lines;
}

}  // namespace roadbalance
