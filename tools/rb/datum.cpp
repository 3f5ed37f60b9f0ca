#include "tools/rb/datum.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include "common/command_line/bus_url.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "host/analyser/recorded_vehicle.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/vehicle_file.hpp"

namespace roadbalance {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

std::vector<ValueToSet> values(const std::string& wheel, double datum_rad, double sigma_rad) {
  const TablePath encoder{{"wheel", wheel}, {"encoder"}};
  const DatumText text = datum_text(datum_rad, sigma_rad);
  return {{encoder, "datum_deg", text.datum_deg}, {encoder, "datum_sigma_deg", text.datum_sigma_deg}};
}

int report(const DatumOptions& options, const FoundDatum& found, std::optional<double> was_rad) {
  const bool write = !options.vehicle.empty() && !options.dry_run;
  const auto to_set = values(options.wheel, found.datum_rad, found.sigma_rad);
  if (write) set_in_vehicle_file(options.vehicle, to_set);
  nlohmann::ordered_json json{{"wheel", options.wheel},
                              {"datum_deg", found.datum_rad * kDegrees},
                              {"datum_sigma_deg", found.sigma_rad * kDegrees},
                              {"was_deg", was_rad ? nlohmann::ordered_json(*was_rad * kDegrees) : nullptr},
                              {"written", write}};
  json.update(found.json);
  if (options.json) {
    std::printf("%s\n", json.dump().c_str());
    return kDone;
  }
  std::printf("%s: datum %.2f +- %.2f deg, %s", options.wheel.c_str(), found.datum_rad * kDegrees,
              found.sigma_rad * kDegrees, found.sentence.c_str());
  if (was_rad) std::printf("; it was %.2f", *was_rad * kDegrees);
  std::printf(".\n");
  if (write)
    std::printf("%s has it now, as it was it is in %s.bak; recordings keep the datum they were made with.\n",
                options.vehicle.c_str(), options.vehicle.c_str());
  else
    std::printf("[wheel.encoder] of %s: %s = %s, %s = %s\n", options.wheel.c_str(), to_set[0].key.c_str(),
                to_set[0].value.c_str(), to_set[1].key.c_str(), to_set[1].value.c_str());
  return kDone;
}

int datum(const DatumOptions& options) {
  const bool by_weight = !options.before.empty() || !options.after.empty();
  if (by_weight &&
      (options.before.empty() || options.after.empty() || options.grams == 0 || options.at.empty()))
    throw ConfigError("a trial weight needs all of --before, --after, --grams and --at");
  if (!by_weight && options.vehicle.empty())
    throw ConfigError(
        "--vehicle FILE says which node reads the wheel; or give --before, --after, --grams, --at");
  std::optional<VehicleConfig> vehicle;
  const WheelConfig* wheel = nullptr;
  if (!options.vehicle.empty()) {
    vehicle = VehicleConfig::read_file(options.vehicle);
    wheel = &wheel_with_mark(*vehicle, options.wheel);
    if (!options.dry_run) check_vehicle_file(options.vehicle, values(options.wheel, 0.0, 0.0));
  }
  const auto found = by_weight ? datum_by_weight(options)
                               : datum_by_turning(options, *wheel, vehicle->node_named(wheel->node));
  if (!found) return kAnswerIsNo;
  return report(options, *found, wheel ? std::optional(wheel->encoder.datum_rad) : std::nullopt);
}

}  // namespace

const WheelConfig& wheel_with_mark(const VehicleConfig& vehicle, const std::string& name) {
  std::string there;
  for (const WheelConfig& wheel : vehicle.wheel) {
    if (wheel.node.empty() || !wheel.encoder.zero_mark) continue;
    if (wheel.name == name) return wheel;
    there += " " + wheel.name;
  }
  throw ConfigError("--wheel " + name +
                    ": no wheel with a zero mark; allowed:" + (there.empty() ? " none" : there));
}

void add_datum(CLI::App& app, int& code) {
  auto options = std::make_shared<DatumOptions>();
  CLI::App* command = app.add_subcommand(
      "datum", "Finds where a wheel's zero mark fires, by turning the wheel by hand or by a trial weight");
  command->add_option("--wheel", options->wheel, "which")->required();
  command->add_option("--vehicle", options->vehicle, "vehicle.toml to set datum_deg and datum_sigma_deg in");
  command->add_flag("--dry-run", options->dry_run, "change no file");
  CLI::Option* const before =
      command->add_option("--before", options->before, "by weight: recording without it");
  CLI::Option* const after = command->add_option("--after", options->after, "by weight: recording with it");
  command->add_option("--readings", options->readings, "by turning: so many")
      ->check(CLI::Range(2, 100))
      ->capture_default_str();
  add_bus_url(*command, options->url, "by turning: LCM address of the bus");
  command->add_option("--seconds", options->patience_s, "by turning: give up after so long; 0: never")
      ->check(seconds_or_zero());
  command->add_option("--grams", options->grams, "by weight: its mass")->check(number_within(0.1, 10e3));
  command->add_option("--at", options->at,
                      "by weight: where it is, degrees from the reference point (valve) in the direction of "
                      "rotation, or the clock with that point at 12");
  command->add_option("--at-sigma-deg", options->at_sigma_deg, "by weight: how well it was put there")
      ->check(number_within(0.0, 90.0))
      ->capture_default_str();
  command->add_option("--radius-m", options->radius_m, "by weight: its radius; default: weight_radius_m")
      ->check(number_within(0.01, 2.0));
  for (const char* const by_turning : {"--readings", "--url", "--seconds"})
    command->get_option(by_turning)->excludes(before)->excludes(after);
  for (const char* const by_weight : {"--grams", "--at", "--at-sigma-deg", "--radius-m"})
    command->get_option(by_weight)->needs(before);
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = datum(*options); });
}

}  // namespace roadbalance
