#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <list>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "host/analysis/balance/readings.hpp"
#include "host/analysis/orders/angle_uncertainty.hpp"
#include "host/analysis/orders/orders_of_record.hpp"
#include "host/analysis/orders/rotor_balance.hpp"
#include "host/analysis/orders/same_rotor.hpp"
#include "host/recording/recorded_vehicle.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/readings_file.hpp"
#include "tools/rb/weighted_drive.hpp"
#include "tools/views/degrees.hpp"
#include "tools/views/digits.hpp"
#include "tools/views/orders_json.hpp"
#include "tools/views/recording_defects.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct BalanceOptions {
  std::string readings;
  std::optional<double> speed;
  std::string rotor;
  std::vector<std::string> drive;
  std::optional<std::string> channel;
  int turns = RotorOrders::kVectorTurns;
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
    json.update(
        {{"rms_before", found.rms_before}, {"rms_after", found.rms_after}, {"condition", found.condition}});
  return json;
}

/// As many digits as the uncertainty allows.
void print_weight(const std::string& plane, const PlaneCorrection& weight, const std::string& unit) {
  const double sigma_deg = degrees(weight.angle_sigma_rad);
  const int of_mass = decimals_by(weight.mass_sigma_g), of_angle = decimals_by(sigma_deg);
  double angle_deg = degrees(weight.angle_rad);
  if (angle_deg + 0.5 * std::pow(10.0, -of_angle) >= 360.0) angle_deg = 0.0;  // it would be printed as 360
  std::printf("%s: %.*f ± %.*f %s at %.*f ± %.*f deg\n", plane.c_str(), of_mass, weight.mass_g, of_mass,
              weight.mass_sigma_g, unit.c_str(), of_angle, angle_deg, of_angle, sigma_deg);
}

void print(const RotorConfig& rotor, const RotorBalance& found) {
  std::printf(
      "# on the rotor without any weight; angles from its own mark in the direction of rotation; ± is one "
      "standard deviation\n");
  for (std::size_t p = 0; p < found.plane.size(); ++p) {
    const PlaneCorrection& plane = found.plane[p];
    if (plane.mass_g == 0.0) continue;
    print_weight(rotor.plane[p].name, plane, "g");
  }
  if (found.by_amplitude)
    std::printf(
        "from amplitudes alone, of %s, the surest of %d channels and speeds; the drives agree to %.0f %%\n",
        found.observation.c_str(), found.observations, 100.0 * std::abs(found.agreement - 1.0));
  else
    std::printf("%d channels and speeds: %.4f m/s^2 rms before, %.4f expected after; condition number %.1f\n",
                found.observations, found.rms_before, found.rms_after, found.condition);
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

Json readings_json(const ReadingsFile& file, const ReadingsBalance& found) {
  const Readings& readings = file.readings;
  Json json{{"refusal", found.refusal.empty() ? Json() : Json(found.refusal)},
            {"method", "influence"},
            {"runs", found.used},
            {"speed", found.speed ? Json(*found.speed) : Json()},
            {"speed_unit", file.speed_unit},
            {"other_speed", Json::array()},
            {"remarks", found.remark},
            {"weight_unit", file.weight_unit},
            {"reading_unit", file.reading_unit},
            {"planes", Json::array()}};
  for (const auto& other : found.other_speed)
    json["other_speed"].push_back({{"run", other.run}, {"speed", other.speed}});
  for (std::size_t p = 0; p < found.plane.size(); ++p)
    json["planes"].push_back(
        {{"plane", readings.plane[p]},
         {"mass", found.plane[p].mass_g},
         {"mass_sigma", found.plane[p].mass_sigma_g},
         {"angle_deg", degrees(found.plane[p].angle_rad)},
         {"angle_sigma_deg", degrees(found.plane[p].angle_sigma_rad)},
         {"rms_without", found.rms_without.empty() ? Json() : Json(found.rms_without[p])}});
  if (found.refusal.empty())
    json.update({{"rms_before", found.balance.rms_before},
                 {"rms_after", found.balance.rms_after},
                 {"condition", found.balance.condition},
                 {"runs_beyond", found.beyond}});
  return json;
}

void print(const ReadingsFile& file, const ReadingsBalance& found) {
  const Readings& readings = file.readings;
  std::printf(
      "# on the rotor without any weight; angles counted as those of the trial weights; ± is one standard "
      "deviation\n");
  for (std::size_t p = 0; p < found.plane.size(); ++p)
    print_weight(readings.plane[p], found.plane[p], file.weight_unit);
  const char* const unit = file.reading_unit.c_str();
  const double before = found.balance.rms_before;
  const double after = found.balance.rms_after < 1e-9 * before ? 0.0 : found.balance.rms_after;  // rounding
  std::printf("%zu runs", found.used.size());
  if (found.speed) std::printf(" at %.4g %s", *found.speed, file.speed_unit.c_str());
  std::printf(", %d beyond those needed; %.4g %s rms before, %.4g expected after; condition number %.1f\n",
              found.beyond, before, unit, after, found.balance.condition);
  for (std::size_t p = 0; p < found.rms_without.size(); ++p)
    std::printf("without a weight in %s: %.4g %s rms\n", readings.plane[p].c_str(), found.rms_without[p],
                unit);
}

int balance_table(const BalanceOptions& options) {
  const ReadingsFile file = ReadingsFile::read(options.readings);
  const ReadingsBalance found = balance_readings(file.readings, options.speed);
  for (const auto& other : found.other_speed)
    std::fprintf(stderr,
                 "rb balance: run %s at %.4g %s is left out: an influence holds for its speed only%s\n",
                 other.run.c_str(), other.speed, file.speed_unit.c_str(),
                 options.speed ? "" : "; --speed chooses another");
  for (const std::string& remark : found.remark) std::fprintf(stderr, "rb balance: %s\n", remark.c_str());
  if (!found.refusal.empty()) std::fprintf(stderr, "rb balance: %s\n", found.refusal.c_str());
  if (options.json)
    std::printf("%s\n", readings_json(file, found).dump().c_str());
  else if (found.refusal.empty())
    print(file, found);
  return found.refusal.empty() ? kDone : kAnswerIsNo;
}

int balance(const BalanceOptions& options) {
  if (!options.readings.empty()) return balance_table(options);
  if (options.drive.empty() || options.rotor.empty())
    throw ConfigError(
        "rb balance: nothing to balance by; allowed: --rotor NAME with recordings, or --readings FILE");
  std::vector<WeightedDrive> drives;
  for (const std::string& text : options.drive) drives.push_back(WeightedDrive::parse(text));
  const RotorConfig rotor = rotor_of_records(drives, options.rotor);
  std::list<RecordOrders> records;
  std::vector<WeightedRun> runs;
  for (const WeightedDrive& drive : drives) {
    WeightedRun& run = runs.emplace_back(WeightedRun{.weight_g = drive.in_planes(rotor), .orders = {}});
    const WantedOrders wanted{.rotor = options.rotor,
                              .channel = options.channel,
                              .all_nodes = !options.channel,
                              .order = {1.0},
                              .block_turns = options.turns};
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
      "balance",
      "Weights for the planes of a rotor, from runs with known weights on it: drives, or readings");
  CLI::Option* const drives = command->add_option(
      "drives", options->drive,
      "recordings: DIR of a drive without weights, DIR:PLANE=GRAMS@DEGREES[,...] of one with");
  CLI::Option* const rotor =
      command->add_option("--rotor", options->rotor, "a [[rotor]] of vehicle.toml, which wheels turn");
  CLI::Option* const channel =
      command->add_option("--channel", options->channel, "this channel only; default: every acceleration");
  CLI::Option* const turns =
      command
          ->add_option("--turns", options->turns, "of a block: fewer for drives of less than a hundred turns")
          ->check(CLI::Range(1, 64))
          ->capture_default_str();
  CLI::Option* const readings = command->add_option("--readings", options->readings,
                                                    "instead of drives, a table of any instrument: first row "
                                                    "names (run, speed or turns, \"weight PLANE\" and "
                                                    "CHANNEL for each, \"sigma CHANNEL\"), second row units, "
                                                    "then a row for each run with AMOUNT@DEGREES; both "
                                                    "angles count in one direction");
  for (CLI::Option* const of_drives : {drives, rotor, channel, turns}) readings->excludes(of_drives);
  command
      ->add_option("--speed", options->speed,
                   "of the runs to compare; default: the one that most runs have, within 1 %")
      ->needs(readings);
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = balance(*options); });
}

}  // namespace roadbalance
