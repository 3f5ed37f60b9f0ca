#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/command_line/bus_url.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/process/stop_on_signal.hpp"
#include "common/types/angle_units.hpp"
#include "host/analysis/calibration/datum_readings.hpp"
#include "host/analysis/calibration/trial_weight.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/recording/recorded_vehicle.hpp"
#include "tools/datum/datum_dialogue.hpp"
#include "tools/datum/edge_listener.hpp"
#include "tools/datum/typed_lines.hpp"
#include "tools/datum/vehicle_file.hpp"
#include "tools/rb/command.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/recording_defects.hpp"
#include "tools/views/wheel_angle.hpp"

namespace roadbalance {
namespace {

struct DatumOptions {
  std::string vehicle;  ///< file to set it in; empty: none
  std::string wheel;
  // By turning.
  std::string url;
  int readings = 5;
  double patience_s = 0;  ///< 0: for ever
  // By a trial weight.
  std::string before, after;  ///< recordings
  double grams = 0;
  std::string at;
  double at_sigma_deg = 2.0;
  std::optional<double> radius_m;  ///< where it is clipped; default: the weight radius
  bool dry_run = false;
  bool json = false;
};

/// The result of a calibration; `json` is printed with --json.
struct FoundDatum {
  double datum_rad;
  double sigma_rad;
  nlohmann::ordered_json json;
  std::string sentence;
};

/// @throws ConfigError naming the wheels that have a zero mark
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

constexpr std::chrono::seconds kSilentBus{3};

void say_line(const std::string& sentence) {
  if (!sentence.empty()) std::fprintf(stderr, "%s\n", sentence.c_str());
}

/// Why no edges come, once; empty: they may.
std::string why_silent(const EdgeListener& listener, const NodeConfig& node, const std::string& url) {
  if (listener.line.heard_blocks()) return {};
  if (listener.line.heard_preview())
    return "node " + node.name +
           " is there, but sends its edges only while somebody records: start rb-recorder beside it";
  return "node " + node.name + " is not heard on " + url;
}

/// True when all readings are there; false if no more can come.
bool lead(DatumDialogue& dialogue, EdgeListener& listener, TypedLines& lines, const DatumOptions& options,
          const NodeConfig& node, const std::stop_token& stop) {
  const WallTime begin = WallClock::now();
  bool silence_said = false;
  while (!dialogue.done() && !stop.stop_requested()) {
    listener.handle(std::chrono::milliseconds(50));
    for (const std::string& sentence : listener.other_versions()) say_line(sentence);
    const WallTime now = WallClock::now();
    for (; !listener.line.edges.empty(); listener.line.edges.pop_front())
      say_line(dialogue.take(listener.line.edges.front(), now));
    say_line(dialogue.tick(now));
    if (!silence_said && now - begin > kSilentBus) {
      silence_said = true;
      say_line(why_silent(listener, node, options.url));
    }
    // Lines of a pipe were written in advance and wait until they are asked for.
    if (lines.terminal() || dialogue.awaits_answer(now)) {
      if (const auto line = lines.next()) say_line(dialogue.answer(*line, now));
      if (lines.ended() && dialogue.awaits_answer(now)) {
        say_line("standard input ended");
        return false;
      }
    }
    if (options.patience_s > 0.0 && now - begin > std::chrono::duration<double>(options.patience_s))
      return false;
  }
  return dialogue.done();
}

/// Reports on standard error what stands in the way, and then returns nothing.
/// @throws ConfigError, or as the recordings and the bus do
std::optional<FoundDatum> datum_by_turning(const DatumOptions& options, const WheelConfig& wheel,
                                           const NodeConfig& node) {
  const StopOnSignal signals;
  TypedLines lines(0);
  EdgeListener listener(options.url, node.id, wheel.line);
  DatumDialogue dialogue(wheel, options.readings);
  say_line(dialogue.greeting());
  if (!lead(dialogue, listener, lines, options, node, signals.token())) {
    std::fprintf(stderr, "rb datum: only %zu of %d readings; nothing is set\n",
                 dialogue.readings().readings(), options.readings);
    return std::nullopt;
  }
  if (const std::string objection = dialogue.objection(); !objection.empty()) {
    std::fprintf(stderr, "rb datum: %s\n", objection.c_str());
    return std::nullopt;
  }
  const auto datum = *dialogue.readings().datum();
  char sentence[160];
  std::snprintf(sentence, sizeof sentence, "from %d readings with a scatter of %.1f deg", options.readings,
                datum.scatter_rad * kDegrees);
  return FoundDatum{
      datum.datum_rad,
      datum.sigma_rad,
      {{"method", "turning"}, {"readings", options.readings}, {"scatter_deg", datum.scatter_rad * kDegrees}},
      sentence};
}

struct Drive {
  FoundUnbalance found;
  double weight_radius_m;
};

/// Nothing, with a line on standard error, if the drive does not determine the wheel's unbalance.
std::optional<Drive> unbalance_in(const std::string& folder, const std::string& wheel_name) {
  const auto vehicle = recorded_vehicle(folder);
  const RecordedEstimate found = identify_record(folder);  // refuses what has no vehicle
  warn_of_defects("datum", folder, found.defects);
  const WheelConfig& wheel = wheel_with_mark(*vehicle, wheel_name);
  const Balance& balance = found.estimate.balance[static_cast<std::size_t>(vehicle->place_of(wheel))];
  if (balance.state != Unknown::kNone) {
    std::fprintf(stderr, "rb datum: %s: the unbalance of %s is not known: %s%s%s\n", folder.c_str(),
                 wheel_name.c_str(), reason(balance.state).c_str(), found.refusal.empty() ? "" : "; ",
                 found.refusal.c_str());
    return std::nullopt;
  }
  return Drive{FoundUnbalance::from(balance, wheel.encoder), wheel.weight_radius_m};
}

TrialWeight weight_of(const DatumOptions& options, double weight_radius_m) {
  const auto angle_rad = parse_wheel_angle(options.at, options.wheel.ends_with("_left"));
  if (!angle_rad)
    throw ConfigError("--at " + options.at +
                      ": is no place on a wheel; allowed: degrees from the reference point in the direction "
                      "of rotation (90), or the clock with the reference point at 12 (9:00)");
  return {options.grams * options.radius_m.value_or(weight_radius_m) / weight_radius_m, *angle_rad,
          options.at_sigma_deg / kDegrees};
}

/// Reports on standard error what stands in the way, and then returns nothing.
/// @throws ConfigError, or as the recordings and the bus do
std::optional<FoundDatum> datum_by_weight(const DatumOptions& options) {
  const auto before = unbalance_in(options.before, options.wheel);
  const auto after = before ? unbalance_in(options.after, options.wheel) : std::nullopt;
  if (!after) return std::nullopt;
  if (before->weight_radius_m != after->weight_radius_m)
    throw ConfigError("weight_radius_m of " + options.wheel + " differs between the two recordings");
  const TrialWeight weight = weight_of(options, before->weight_radius_m);
  const auto datum = datum_by_trial_weight(before->found, after->found, weight);
  if (!datum) {
    std::fprintf(stderr,
                 "rb datum: the two drives do not tell the weight: take a heavier one, or drive longer\n");
    return std::nullopt;
  }
  if (!datum->mass_agrees(weight)) {
    std::fprintf(stderr,
                 "rb datum: the drives find %.1f +- %.1f g of change where %.1f g were clipped on: the scale "
                 "is wrong, and with it the angle. Check the wheel's mass_kg, the weight's radius and that "
                 "nothing else was changed; nothing is set\n",
                 datum->change_g, datum->change_sigma_g, weight.mass_g);
    return std::nullopt;
  }
  char sentence[160];
  std::snprintf(sentence, sizeof sentence, "from a trial weight of %.1f g, found as %.1f +- %.1f g",
                weight.mass_g, datum->change_g, datum->change_sigma_g);
  return FoundDatum{datum->datum_rad,
                    datum->sigma_rad,
                    {{"method", "trial_weight"},
                     {"weight_g", weight.mass_g},
                     {"change_g", datum->change_g},
                     {"change_sigma_g", datum->change_sigma_g}},
                    sentence};
}

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
