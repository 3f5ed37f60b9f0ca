#include "host/recorder/control/requested_vehicle.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <system_error>
#include <utility>

#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "common/types/angle_units.hpp"
#include "host/recorder/control/vehicle_edit.hpp"

namespace roadbalance {
namespace {

std::string vehicles_beside(const std::filesystem::path& file, Disk& disk) {
  std::vector<std::string> names;
  for (const std::string& name : list_folder(folder_of(file), disk))
    if (is_vehicle_file_name(name)) names.push_back(name);
  std::ranges::sort(names);
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

}  // namespace

std::string read_vehicle_file(const std::filesystem::path& file, Disk& disk) {
  const auto text = read_whole_text(file, disk);
  if (!text)
    throw std::system_error(std::make_error_code(std::errc::no_such_file_or_directory), file.string());
  return *text;
}

bool is_vehicle_file_name(const std::string& name) {
  return name.size() > 5 && name.ends_with(".toml") && name.front() != '.' &&
         name.find_first_of("/\\") == std::string::npos;
}

std::string what_is_done(const Request& request, const std::filesystem::path& file) {
  char text[160];
  switch (request.operation) {
    case Operation::kRange:
      std::snprintf(text, sizeof text, "channel %d.%d has a range of %g m/s²", request.node,
                    request.channel + 1, request.value[0]);
      return text;
    case Operation::kFilter:
      std::snprintf(text, sizeof text, "every node filters above %g Hz", request.value[0]);
      return text;
    case Operation::kDatum:
      std::snprintf(text, sizeof text, "%s: its zero mark fires at %.2f ± %.2f deg",
                    0 <= request.channel && request.channel < kWheels
                        ? kWheelNames[static_cast<std::size_t>(request.channel)]
                        : "a wheel",
                    request.value[0] * kDegrees, request.value[1] * kDegrees);
      return text;
    case Operation::kZero:
      return request.node == 0 ? "every channel's reading at rest is its zero"
                               : "node " + std::to_string(request.node) + ": readings at rest are the zeros";
    default:
      return file.filename().string() + " is in force";
  }
}

RequestedVehicle::Wanted RequestedVehicle::find(const Request& request, const std::filesystem::path& file,
                                                const std::string& text,
                                                const std::vector<std::int32_t>& nodes, WallTime now) {
  if (nodes.empty()) throw SetUpRefusal{RefusalReason::kNoNode, "no node is on the bus"};
  const auto vehicle = [&] { return VehicleConfig::parse(text, file.string()); };
  Wanted wanted{.file = file};
  switch (request.operation) {
    case Operation::kRange:
      if (std::ranges::find(nodes, request.node) == nodes.end())
        throw SetUpRefusal{RefusalReason::kNoNode,
                           "node " + std::to_string(request.node) + " is not on the bus"};
      wanted.text = with_range(text, request);
      break;
    case Operation::kFilter:
      wanted.text = with_filter(text, request);
      break;
    case Operation::kZero:
      wanted.text = with_zero(text, standstill(request, vehicle(), nodes, now));
      break;
    case Operation::kDatum:
      wanted.text = with_datum(text, request);
      break;
    case Operation::kScale:
      return scaled(request, std::move(wanted), text, vehicle(), nodes, now);
    default:
      wanted.file = folder_of(file) / request.text;
      if (!is_vehicle_file_name(request.text) || !path_exists(wanted.file, disk_))
        throw SetUpRefusal{RefusalReason::kBadArgument, "there is no vehicle file of this name; there are: " +
                                                            vehicles_beside(file, disk_)};
      wanted.text = read_vehicle_file(wanted.file, disk_);
      break;
  }
  wanted.words = what_is_done(request, wanted.file);
  return wanted;
}

RequestedVehicle::Readings RequestedVehicle::standstill(const Request& request, const VehicleConfig& vehicle,
                                                        const std::vector<std::int32_t>& nodes,
                                                        WallTime now) const {
  Readings readings;
  for (const NodeConfig& node : vehicle.node) {
    if (std::ranges::find(nodes, node.id) == nodes.end() || (request.node != 0 && request.node != node.id))
      continue;
    StandstillReadings::Reading reading = readings_.of(node, now);
    if (!reading.fault.empty()) throw SetUpRefusal{RefusalReason::kMoving, reading.fault};
    readings[node.id] = reading;
  }
  if (readings.empty()) throw SetUpRefusal{RefusalReason::kNoNode, "this node is not on the bus"};
  return readings;
}

// There is a text once the channel has been read both ways up.
RequestedVehicle::Wanted RequestedVehicle::scaled(const Request& request, Wanted wanted,
                                                  const std::string& text, const VehicleConfig& vehicle,
                                                  const std::vector<std::int32_t>& nodes, WallTime now) {
  const NodeConfig* node = vehicle.node_with_id(request.node);
  if (!node || request.channel < 0 || request.channel >= static_cast<int>(node->channel.size()) ||
      std::abs(request.value[0]) != 1.0)
    throw SetUpRefusal{RefusalReason::kBadArgument,
                       "a scale is of a channel of vehicle.toml, its arrow up or down"};
  const double mean_counts = standstill(request, vehicle, nodes, now)
                                 .at(node->id)
                                 .mean_counts[static_cast<std::size_t>(request.channel)];
  const TurnOver::Result result =
      turn_over_.take(*node, request.channel, request.value[0] > 0, mean_counts, now);
  if (result.is_refused) throw SetUpRefusal{RefusalReason::kBadArgument, result.text};
  if (result.found) wanted.text = with_calibration(text, *node, request.channel, *result.found);
  wanted.words = result.text;
  return wanted;
}

}  // namespace roadbalance
