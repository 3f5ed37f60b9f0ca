#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "common/config/section.hpp"
#include "tools/study/chain_studies.hpp"
#include "tools/study/demo_accuracy.hpp"
#include "tools/study/drift_cost.hpp"
#include "tools/study/estimator_trial.hpp"
#include "tools/study/exact_studies.hpp"
#include "tools/study/fig3.hpp"
#include "tools/study/ideal_studies.hpp"
#include "tools/study/real_studies.hpp"
#include "tools/study/study.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

Json run_demo(const StudyRun& run) {
  return demo_accuracy_run(run.seed, run.settings["drive_seconds"].get<double>());
}

/// Distribution of the sizes of one number over the wheels of "seeds".
Figure of_seeds(const Json& summary, const std::string& name, const std::string& title,
                const std::string& unit, const std::vector<std::pair<std::string, std::string>>& keys) {
  Figure figure{name, title, {unit}, {"wheels with no more, %"}, {}};
  for (const auto& [words, key] : keys) {
    std::vector<double> values;
    for (const Json& seed : summary["seeds"])
      for (const Json& wheel : seed["wheels"])
        values.push_back(wheel[key].is_number() ? wheel[key].get<double>() : std::nan(""));
    figure.series.push_back(distribution(words, values));
  }
  return figure;
}

StudyResult summarise_demo(const Json&, const std::vector<Json>& runs) {
  Json summary = demo_accuracy_summary(runs);
  summary["results"] = runs;
  return {summary,
          {of_seeds(summary, "demo-accuracy", "Errors of the demo's estimates", "%",
                    {{"mass", "error_percent"}, {"tyre stiffness", "error_tyre_percent"}}),
           of_seeds(summary, "demo-accuracy-angle", "Errors of the demo's angles", "deg",
                    {{"angle", "error_deg"}})}};
}

Json run_drift(const StudyRun& run) {
  return drift_cost_run(run.seed, run.folder);
}

StudyResult summarise_drift(const Json&, const std::vector<Json>& runs) {
  const Json summary = drift_cost_summary(runs);
  return {summary,
          {of_seeds(summary, "drift", "Change of the unbalance by a drift of 5 km/h a minute", "% or deg",
                    {{"mass, %", "change_percent"}, {"angle, deg", "change_deg"}})}};
}

std::vector<Study> old_studies() {
  const std::vector<std::string> repeated{"--runs", "--seed", "--state", "--jobs", "--svg", "--markdown"};
  std::vector<std::string> with_length = repeated;
  with_length.push_back("--drive-seconds");
  return {{.name = "demo-accuracy",
           .line = "the demo's estimates against the truth",
           .options = with_length,
           .settings = {{"drive_seconds", 320.0}},
           .run = run_demo,
           .summarise = summarise_demo},
          {.name = "drift",
           .line = "what a drift of 5 km/h a minute costs the identified unbalance",
           .options = repeated,
           .settings = Json::object(),
           .run = run_drift,
           .summarise = summarise_drift},
          {.name = "clock-skew",
           .line = "the fits of running nodes' clocks against what they show",
           .options = {"--seconds", "--nodes"},
           .settings = Json::object()},
          {.name = "encoder",
           .line = "angles from pulse trains against the truth",
           .options = {"--runs", "--seed", "--markdown"},
           .settings = Json::object(),
           .runs = 1,
           .seed = 11}};
}

std::string names(const auto& all, const auto& name_of) {
  std::string text;
  for (const auto& one : all) text += (text.empty() ? "" : ", ") + name_of(one);
  return text;
}

/// Bounds of a numeric setting by its key, which means the same to all studies.  Drives of less than a
/// second have no spectrum; the bound needs a rough road, and a rear road that is not the front's alone.
const std::map<std::string, Range> kAllowed{
    {"samples", {500.0, 1e7}},     {"road_gd_m3", {1e-9, 1.0}},  {"rear_coherence2", {0.0, 0.9999}},
    {"seconds", {10.0, 1e5}},      {"force_n", {0.0, 1e4}},      {"drives", {8.0, 1000.0}},
    {"tyre_percent", {0.0, 20.0}}, {"unbalance_g", {0.0, 100.0}}};

/// @throws ConfigError if the setting's value, of the right kind, cannot be studied
void check(const std::string& key, const Json& value, const std::string& change) {
  if (value.is_array())
    for (const Json& element : value) check(key, element, change);
  if (key == "estimators") chosen_estimators(value.get<std::string>());
  if (key == "road" && !std::set<Json>{"A", "B", "C", "S"}.contains(value))
    throw ConfigError("--set " + change + ": allowed: A, B, C or S");
  const auto allowed = kAllowed.find(key);
  if (allowed == kAllowed.end() || !value.is_number()) return;
  const auto [low, high] = allowed->second;
  if (!(value.get<double>() >= low && value.get<double>() <= high))
    throw ConfigError("--set " + change + ": allowed: " + Json(low).dump() + " .. " + Json(high).dump());
}

/// `text` as a value of the kind that `old` is of.
Json value_like(const Json& old, const std::string& text, const std::string& change) {
  if (old.is_string()) return text;
  if (old.is_array()) {
    Json array = Json::array();
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t end = std::min(text.find(',', begin), text.size());
      if (end > begin) array.push_back(value_like(old.front(), text.substr(begin, end - begin), change));
      begin = end + 1;
    }
    if (array.empty()) throw ConfigError("--set " + change + ": at least one value is needed");
    return array;
  }
  const Json value = Json::parse(text, nullptr, false);
  const bool fits = old.is_number_integer() ? value.is_number_integer()
                    : old.is_number()       ? value.is_number()
                                            : value.is_boolean() && old.is_boolean();
  if (!fits) throw ConfigError("--set " + change + ": allowed: a value like " + old.dump());
  return old.is_number_float() ? Json(value.get<double>()) : value;
}

}  // namespace

std::span<const Study> studies() {
  static const std::vector<Study> kAll = [] {
    std::vector<Study> all{fig3_study(),         fig4_study(),         influences_study(),
                           estimators_study(),   cancellation_study(), parameters_study(),
                           quantisation_study(), radial_force_study(), coverage_study(),
                           hazards_study(),      real_road_study(),    end_to_end_study(),
                           equations_study(),    many_drives_study()};
    for (Study& study : old_studies()) all.push_back(std::move(study));
    return all;
  }();
  return kAll;
}

const Study& study_of(const std::string& name) {
  for (const Study& study : studies())
    if (study.name == name) return study;
  throw ConfigError("study " + name + ": there is none of this name; allowed: list, " +
                    names(studies(), [](const Study& study) { return study.name; }));
}

void change_setting(Json& settings, const std::string& change) {
  const std::size_t equals = change.find('=');
  const std::string key = change.substr(0, equals);
  if (equals == std::string::npos || !settings.contains(key))
    throw ConfigError("--set " + change + ": allowed: KEY=VALUE with KEY one of " +
                      names(settings.items(), [](const auto& entry) { return entry.key(); }));
  const Json value = value_like(settings[key], change.substr(equals + 1), change);
  check(key, value, change);
  settings[key] = value;
}

}  // namespace roadbalance
