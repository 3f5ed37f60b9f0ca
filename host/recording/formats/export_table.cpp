#include "host/recording/formats/export_table.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "common/config/section.hpp"
#include "common/text/format.hpp"
#include "common/types/bounded_time.hpp"
#include "common/types/crc32c.hpp"
#include "host/recording/formats/survey.hpp"
#include "host/recording/formats/unique_names.hpp"

namespace roadbalance {
namespace {

/// Samples this near to a grid, in periods, are its rows: more than rounding to nanoseconds moves them.
constexpr double kOnGrid = 0.02;
/// No crystal is this far off: the time base has broken between the first and the last sample.
constexpr double kMostDrift = 1e-3;

/// The position of an instant on a grid from `origin_ns` on, in periods.
double position(std::int64_t time_ns, std::int64_t origin_ns, std::int64_t period_ps) {
  return static_cast<double>(time_ns - origin_ns) * 1000.0 / static_cast<double>(period_ps);
}

bool is_on_grid(const RecordedSpan& span, std::int64_t origin_ns, std::int64_t period_ps) {
  const double begin = position(span.first_ns, origin_ns, period_ps);
  const double end = position(span.last_ns, origin_ns, period_ps);
  return span.period_ps == period_ps && std::abs(begin) <= static_cast<double>(kIndexLimit) &&
         std::abs(begin - std::round(begin)) <= kOnGrid &&
         std::abs(end - std::round(begin) - static_cast<double>(span.next_scan - span.first_scan)) <= kOnGrid;
}

bool overlap(const RecordedSpan& a, const RecordedSpan& b) {
  return a.node == b.node && a.first_ns < b.last_ns && b.first_ns < a.last_ns;
}

std::size_t place_of(const VehicleConfig& vehicle, std::int32_t node) {
  const auto found = std::ranges::find(vehicle.node, node, &NodeConfig::id);
  return static_cast<std::size_t>(found - vehicle.node.begin());
}

/// All channels of a node that can be exported, with their places in its scans.
std::vector<std::pair<std::size_t, ExportChannel>> channels_of(const VehicleConfig& vehicle,
                                                               const NodeConfig& node) {
  std::vector<std::pair<std::size_t, ExportChannel>> all;
  for (std::size_t k = 0; k < node.channel.size(); ++k) {
    const ChannelConfig& from = node.channel[k];
    if (from.role == ChannelRole::kUnused) continue;
    all.push_back({k,
                   {.name = from.name,
                    .unit = from.role == ChannelRole::kRoad ? "m" : "m/s^2",
                    .node = node.name,
                    .scale = from.scale_m_s2_per_count,
                    .offset_counts = from.offset_counts,
                    .mount = from.mount,
                    .position_m = from.position_m,
                    .direction = from.direction,
                    .range = from.range_m_s2,
                    .delay_s = from.delay_s}});
  }
  for (int line = 0; line < kEncoderLines; ++line) {
    const WheelConfig* wheel = vehicle.wheel_at(node, line);
    if (wheel == nullptr) continue;
    for (int k = 0; k < 2; ++k)
      all.push_back({static_cast<std::size_t>(kAccelerations + 2 * line + k),
                     {.name = wheel->name + (k == 0 ? "_angle_sin" : "_angle_cos"),
                      .unit = "1",
                      .node = node.name,
                      .scale = 1.0 / kFullScaleCounts,
                      .mount = wheel->name,
                      .range = 1.0}});
  }
  return all;
}

/// The CRC of what the counts of each channel of the vehicle mean.
std::uint32_t meaning_crc32c(const VehicleConfig& vehicle) {
  std::string text;
  for (const NodeConfig& node : vehicle.node)
    for (const auto& [converter, channel] : channels_of(vehicle, node))
      text += format("%s\n%s\n%s\n%.17g\n%.17g\n", channel.node.c_str(), channel.name.c_str(),
                     channel.unit.c_str(), channel.scale, channel.offset_counts);
  return crc32c({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

/// Adds a span to a group, with the columns that its node has there already if it was there before.
void add_part(const VehicleConfig& vehicle, const RecordedSpan& span, std::int64_t first_row,
              ExportGroup& group) {
  const NodeConfig* node = vehicle.node_with_id(span.node);
  if (node == nullptr) return;  // vehicle.toml lacks this node: its channels are unknown
  ExportPart part{.node = span.node,
                  .epoch = span.epoch,
                  .first_scan = span.first_scan,
                  .first_row = first_row,
                  .first_fit = span.first_fit};
  const auto known = std::find_if(group.part.begin(), group.part.end(),
                                  [&](const ExportPart& other) { return other.node == span.node; });
  if (known != group.part.end()) {
    part.column = known->column;
    for (const auto& [converter, column] : part.column)
      if (span.overload >> converter & 1) group.channel[column].overload = true;
  } else {
    std::size_t number = 0;
    for (const NodeConfig& before : vehicle.node) {
      if (&before == node) break;
      number += channels_of(vehicle, before).size();
    }
    for (auto& [converter, channel] : channels_of(vehicle, *node)) {
      channel.number = number++;
      channel.overload = (span.overload >> converter & 1) != 0;
      part.column.push_back({.converter = converter, .column = group.channel.size()});
      group.channel.push_back(std::move(channel));
    }
  }
  group.rows = std::max(group.rows, first_row + span.next_scan - span.first_scan);
  group.part.push_back(std::move(part));
}

/// Those of a node stay in the order in which they began.
void sort_by_node(const VehicleConfig& vehicle, std::vector<const RecordedSpan*>& spans) {
  std::ranges::stable_sort(spans, {}, [&](const auto* span) { return place_of(vehicle, span->node); });
}

/// All spans on the grid of the earliest, as one group; the others remain in `left`.
ExportGroup common_group(const VehicleConfig& vehicle, std::vector<const RecordedSpan*>& left) {
  const auto earliest = std::min_element(
      left.begin(), left.end(), [](const auto* a, const auto* b) { return a->first_ns < b->first_ns; });
  const RecordedSpan& first = **earliest;
  ExportGroup group{.name = "all",
                    .rate_hz = 1e12 / static_cast<double>(first.period_ps),
                    .first_ns = first.first_ns,
                    .origin_ns = first.first_ns,
                    .period_ps = first.period_ps,
                    .shared_time = true};
  std::vector<const RecordedSpan*> taken, others;
  for (const RecordedSpan* span : left) {
    const bool fits =
        is_on_grid(*span, first.first_ns, first.period_ps) &&
        std::none_of(taken.begin(), taken.end(), [&](const auto* t) { return overlap(*t, *span); });
    (fits ? taken : others).push_back(span);
  }
  sort_by_node(vehicle, taken);
  for (const RecordedSpan* span : taken)
    add_part(vehicle, *span, std::llround(position(span->first_ns, first.first_ns, first.period_ps)), group);
  left = std::move(others);
  return group;
}

std::string name_of(const VehicleConfig& vehicle, std::int32_t id) {
  const NodeConfig* node = vehicle.node_with_id(id);
  return node ? node->name : "node" + std::to_string(id);
}

ExportGroup own_group(const VehicleConfig& vehicle, const RecordedSpan& span, int number) {
  ExportGroup group{.name = name_of(vehicle, span.node),
                    .first_ns = span.first_host_ns(),
                    .origin_ns = span.first_host_ns(),
                    .period_ps = span.period_ps};
  if (number > 1) group.name += "_" + std::to_string(number);
  const auto seconds = static_cast<double>(span.end_ns() - group.first_ns) * 1e-9;
  const auto scans = static_cast<double>(span.next_scan - span.first_scan);
  const double nominal_hz = 1e12 / static_cast<double>(span.period_ps);
  const double mean_hz = seconds > 0.0 ? scans / seconds : nominal_hz;
  group.rate_hz = std::abs(mean_hz / nominal_hz - 1.0) < kMostDrift ? mean_hz : nominal_hz;
  add_part(vehicle, span, 0, group);
  return group;
}

std::vector<ExportGroup> groups_of(const RecordingSurvey& survey, const VehicleConfig& vehicle) {
  std::vector<const RecordedSpan*> left;
  for (const auto& span : survey.span) left.push_back(&span);
  std::vector<ExportGroup> groups;
  if (survey.own_clocks())
    std::erase_if(left, [](const auto* span) { return !span->first_fit; });
  else
    groups.push_back(common_group(vehicle, left));
  sort_by_node(vehicle, left);
  std::map<std::int32_t, int> seen;
  for (const RecordedSpan* span : left) groups.push_back(own_group(vehicle, *span, ++seen[span->node]));
  std::erase_if(groups, [](const ExportGroup& group) { return group.channel.empty() || group.rows == 0; });
  return groups;
}

/// Drops the columns whose channel is not among `names`, and puts the others into their order.
void keep_channels(const std::vector<std::string>& names, ExportGroup& group) {
  std::vector<ExportChannel> kept;
  std::map<std::size_t, std::size_t> place;  // [column before]
  for (const std::string& name : names)
    for (std::size_t c = 0; c < group.channel.size(); ++c) {
      const ExportChannel& channel = group.channel[c];
      if (channel.name != name && channel.node != name) continue;
      if (place.emplace(c, kept.size()).second) kept.push_back(channel);
    }
  for (ExportPart& part : group.part) {
    std::erase_if(part.column, [&](const ExportPart::Column& one) { return !place.contains(one.column); });
    for (ExportPart::Column& one : part.column) one.column = place.at(one.column);
  }
  group.channel = std::move(kept);
}

void check_names(const std::vector<std::string>& wanted, const ExportTable& table) {
  std::set<std::string> names;
  std::string all;
  for (const auto& group : table.group)
    for (const auto& channel : group.channel) {
      if (names.insert(channel.node).second) all += " " + channel.node;
      if (names.insert(channel.name).second) all += " " + channel.name;
    }
  for (const auto& name : wanted)
    if (!names.contains(name))
      throw ConfigError("--channels: " + name + ": no such channel or node; allowed:" + all);
}

/// Rows of `group` from from_s up to, and without, to_s.
void keep_rows(const ExportSelection& selection, ExportGroup& group) {
  const auto row_at = [&](double seconds) {
    // A limit on a row includes that row, despite rounding.
    const double row = (seconds - static_cast<double>(group.first_ns) * 1e-9) * group.rate_hz - 1e-3;
    return static_cast<std::int64_t>(std::ceil(std::clamp(row, 0.0, static_cast<double>(group.rows))));
  };
  const std::int64_t end = selection.to_s ? row_at(*selection.to_s) : group.rows;
  group.first_row = std::min(row_at(selection.from_s), end);
  group.rows = end - group.first_row;
  group.first_ns += group.shared_time
                        ? time_after_ns(group.origin_ns, group.first_row, group.period_ps) - group.origin_ns
                        : std::llround(static_cast<double>(group.first_row) * 1e9 / group.rate_hz);
}

}  // namespace

ExportTable make_table(const RecordingSurvey& survey) {
  const VehicleConfig vehicle = with_unique_names(survey.vehicle);
  ExportTable table{.vehicle = survey.vehicle.name,
                    .vehicle_toml = survey.vehicle.text,
                    .program = survey.program,
                    .meaning_crc32c = meaning_crc32c(vehicle),
                    .group = groups_of(survey, vehicle)};
  table.start_utc_us = survey.start_utc_us;
  table.start_by_clock = survey.start_by_clock;
  table.own_clocks = survey.own_clocks();
  for (const auto& span : survey.span)
    if (table.own_clocks && !span.first_fit)
      table.left_out.push_back({name_of(survey.vehicle, span.node), span.next_scan - span.first_scan});
  if (table.group.empty()) return table;
  table.start_ns = std::min_element(table.group.begin(), table.group.end(), [](const auto& a, const auto& b) {
                     return a.first_ns < b.first_ns;
                   })->first_ns;
  for (auto& group : table.group) group.first_ns -= table.start_ns;
  for (const auto& mark : survey.mark)
    table.mark.push_back({(survey.notes_have_time() ? mark.host_ns : mark.last_sample_ns) - table.start_ns,
                          mark.number, mark.text});
  return table;
}

void select(const ExportSelection& selection, ExportTable& table) {
  if (selection.to_s && *selection.to_s <= selection.from_s)
    throw ConfigError("--to: not after --from; allowed: a later time");
  check_names(selection.channels, table);
  for (auto& group : table.group) {
    if (!selection.channels.empty()) keep_channels(selection.channels, group);
    keep_rows(selection, group);
  }
  std::erase_if(table.group,
                [](const ExportGroup& group) { return group.channel.empty() || group.rows == 0; });
  if (table.group.empty()) throw ConfigError("--from, --to: no sample between them");
  const auto outside = [&](const ExportMark& mark) {
    const double seconds = static_cast<double>(mark.time_ns) * 1e-9;
    return (selection.from_s > 0.0 && seconds < selection.from_s) ||
           (selection.to_s && seconds >= *selection.to_s);
  };
  std::erase_if(table.mark, outside);
}

}  // namespace roadbalance
