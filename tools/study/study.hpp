#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tools/study/figure.hpp"

namespace roadbalance {

/// One run of a study.
struct StudyRun {
  std::uint64_t seed;
  const nlohmann::ordered_json& settings;
  const std::filesystem::path& folder;  ///< for its files, which are not read afterwards
};

struct StudyResult {
  /// {"tables": [{"title", "rows": [{column: value}]}],
  /// "acceptance": [acceptance_line()], "accepted"} and further
  /// results; without "acceptance" nothing was required, and with none in it nothing is accepted.
  nlohmann::ordered_json summary;
  std::vector<Figure> figures;
};

/// An experiment repeated over many seeds, and the summary of the runs.
struct Study {
  std::string name;
  std::string line;                  ///< what it is, in one line
  std::vector<std::string> options;  ///< of `rb study`, beside --json, that mean something to it
  nlohmann::ordered_json settings;   ///< inputs of a run beside its seed, with their defaults
  int runs = 20;
  std::uint64_t seed = 1;
  /// A pure function of its argument.  None: there is nothing to repeat.
  nlohmann::ordered_json (*run)(const StudyRun&) = nullptr;
  /// None: the command has its own way.
  StudyResult (*summarise)(const nlohmann::ordered_json& settings,
                           const std::vector<nlohmann::ordered_json>& runs) = nullptr;
};

/// All there are, in the order in which they are listed.
std::span<const Study> studies();

/// @throws ConfigError naming the studies there are
const Study& study_of(const std::string& name);

/// Changes a setting by "key=value"; the value is of the kind that it has already, an array's elements
/// divided by commas.
/// @throws ConfigError naming the settings there are, or what is allowed; `settings` are unchanged then
void change_setting(nlohmann::ordered_json& settings, const std::string& change);

/// The tables of a summary, for a terminal: columns side by side.
std::string plain_tables(const nlohmann::ordered_json& summary);
/// Its acceptance, a line each: "met", "NOT MET" or "not judged", what was asked, the value, its limits and
/// on how many answers it rests; nothing if nothing was required.
std::string plain_acceptance(const nlohmann::ordered_json& summary);
/// The same and the acceptance as Markdown.
std::string markdown_tables(const nlohmann::ordered_json& summary);

}  // namespace roadbalance
