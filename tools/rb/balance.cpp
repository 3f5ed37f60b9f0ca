#include <CLI/CLI.hpp>
#include <cstdio>
#include <list>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "host/analysis/orders/angle_uncertainty.hpp"
#include "host/analysis/orders/orders_of_record.hpp"
#include "host/analysis/orders/rotor_balance.hpp"
#include "host/analysis/orders/same_rotor.hpp"
#include "host/recording/recorded_vehicle.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/weighted_drive.hpp"
#include "tools/views/degrees.hpp"
#include "tools/views/orders_json.hpp"
#include "tools/views/recording_defects.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct BalanceOptions {
  std::string rotor;
  std::vector<std::string> drive;
  std::optional<std::string> channel;
  bool json = false;
};

/// The vehicle of a recording that has the rotor.
VehicleConfig vehicle_of_record(const std::string& folder, const std::string& name) {
  VehicleConfig vehicle = vehicle_of_recording(folder);
  if (vehicle.rotor_named(name)) return vehicle;
  std::string there;
  for (const RotorConfig& each : vehicle.rotor) there += " " + each.name;
  throw ConfigError("--rotor " + name + ": " + folder + ": there is no such rotor; allowed:" +
                    (there.empty() ? " none: vehicle.toml has no [[rotor]]" : there));
}

Json balance_json(const RotorConfig& rotor, const RotorBalance& found) {
  Json json{{"rotor", rotor.name},
            {"refusal", found.refusal.empty() ? Json() : Json(found.refusal)},
            {"method", found.by_amplitude ? "four_runs" : "influence"},
            {"observations", found.observations},
            {"observation", found.observation.empty() ? Json() : Json(found.observation)},
            {"planes", Json::array()}};
  for (std::size_t p = 0; p < found.plane.size(); ++p)
    json["planes"].push_back({{"plane", rotor.plane[p].name},
                              {"mass_g", found.plane[p].mass_g},
                              {"mass_sigma_g", found.plane[p].mass_sigma_g},
                              {"angle_deg", degrees(found.plane[p].angle_rad)},
                              {"angle_sigma_deg", degrees(found.plane[p].angle_sigma_rad)},
                              {"weight_radius_m", rotor.plane[p].weight_radius_m}});
  if (found.by_amplitude)
    json["agreement"] = found.agreement;
  else
    json.update({{"rms_before", found.rms_before}, {"rms_after", found.rms_after}});
  return json;
}

void print(const RotorConfig& rotor, const RotorBalance& found) {
  std::printf(
      "# on the rotor without any weight; angles from its own mark in the direction of rotation; ± is one "
      "standard deviation\n");
  for (std::size_t p = 0; p < found.plane.size(); ++p) {
    const PlaneCorrection& plane = found.plane[p];
    if (plane.mass_g == 0.0) continue;
    std::printf("%s: %.1f ± %.1f g at %.0f ± %.0f deg\n", rotor.plane[p].name.c_str(), plane.mass_g,
                plane.mass_sigma_g, degrees(plane.angle_rad), degrees(plane.angle_sigma_rad));
  }
  if (found.by_amplitude)
    std::printf(
        "from amplitudes alone, of %s, the surest of %d channels and speeds; the drives agree to %.0f %%\n",
        found.observation.c_str(), found.observations, 100.0 * std::abs(found.agreement - 1.0));
  else
    std::printf("%d channels and speeds: %.4f m/s^2 rms before, %.4f expected after\n", found.observations,
                found.rms_before, found.rms_after);
}

/// @throws ConfigError naming the recording whose rotor is another than that of the first
RotorConfig rotor_of_records(const std::vector<WeightedDrive>& drives, const std::string& name) {
  const VehicleConfig first = vehicle_of_record(drives.front().folder, name);
  for (const WeightedDrive& drive : drives)
    if (const std::string why = difference(first, vehicle_of_record(drive.folder, name), name); !why.empty())
      throw ConfigError(drives.front().folder + " and " + drive.folder + " cannot be compared: " + why);
  return *first.rotor_named(name);
}

/// The angle may have been read better, or the encoder fitted anew: a record does not show which.
void warn_of_datum(const WeightedDrive& first, double first_rad, const WeightedDrive& drive, double rad) {
  if (rad != first_rad)
    std::fprintf(stderr,
                 "rb balance: %s: its datum is %.1f deg ahead of that of %s; taken as read anew, the encoder "
                 "as it was\n",
                 drive.folder.c_str(), degrees(rad - first_rad), first.folder.c_str());
}

/// Warns of the reasons for which channels or phases of the drive are not used.
void warn_of(const std::string& folder, const RecordOrders& found) {
  std::set<std::string> remarks;
  for (const auto& orders : found.rotor) remarks.insert(remark_on(found, *orders));
  for (const std::string& remark : remarks)
    if (!remark.empty()) std::fprintf(stderr, "rb balance: %s: %s\n", folder.c_str(), remark.c_str());
}

int balance(const BalanceOptions& options) {
  std::vector<WeightedDrive> drives;
  for (const std::string& text : options.drive) drives.push_back(WeightedDrive::parse(text));
  const RotorConfig rotor = rotor_of_records(drives, options.rotor);
  std::list<RecordOrders> records;
  std::vector<WeightedRun> runs;
  for (const WeightedDrive& drive : drives) {
    WeightedRun& run = runs.emplace_back(WeightedRun{.weight_g = drive.in_planes(rotor), .orders = {}});
    const WantedOrders wanted{
        .rotor = options.rotor, .channel = options.channel, .all_nodes = !options.channel, .order = {1.0}};
    const RecordOrders& found = records.emplace_back(orders_of_record(drive.folder, wanted));
    warn_of_defects("balance", drive.folder, found.defects);
    warn_of(drive.folder, found);
    for (const auto& orders : found.rotor) run.orders.push_back(orders.get());
    run.datum_rad = datum_of(found.vehicle, rotor);
    warn_of_datum(drives.front(), runs.front().datum_rad, drive, run.datum_rad);
    run.phase_sigma_rad = angle_uncertainty(found, found.rotor.front()->rotor()).common_sigma_rad;
  }
  const RotorBalance found = balance_rotor(rotor, runs);
  if (!found.refusal.empty()) std::fprintf(stderr, "rb balance: %s\n", found.refusal.c_str());
  if (options.json)
    std::printf("%s\n", balance_json(rotor, found).dump().c_str());
  else if (found.refusal.empty())
    print(rotor, found);
  return found.refusal.empty() ? kDone : kAnswerIsNo;
}

}  // namespace

void add_balance(CLI::App& app, int& code) {
  auto options = std::make_shared<BalanceOptions>();
  CLI::App* command = app.add_subcommand(
      "balance", "Weights for the planes of a rotor that wheels turn, from drives with known weights on it");
  command
      ->add_option("drives", options->drive,
                   "recordings: DIR of a drive without weights, DIR:PLANE=GRAMS@DEGREES[,...] of one with")
      ->required();
  command->add_option("--rotor", options->rotor, "a [[rotor]] of vehicle.toml")->required();
  command->add_option("--channel", options->channel, "this channel only; default: every acceleration");
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = balance(*options); });
}

}  // namespace roadbalance
