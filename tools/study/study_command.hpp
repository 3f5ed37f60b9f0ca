#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "tools/study/campaign.hpp"

namespace CLI {
class App;
}

namespace roadbalance {

/// How the runs of a study are shared out: over the cores of this machine, or over a cluster.  Returns
/// nothing where another process prints the result.
using Campaigner = std::function<std::optional<std::vector<nlohmann::ordered_json>>(
    const Campaign& campaign, const Experiment& experiment)>;

/// The purpose of the command, in one line.
inline constexpr const char* kStudySentence =
    "Repeats an experiment over many seeds and prints what came out";

/// Makes a command one that runs a study: its name and options; of commands a command below it goes before.
/// The callback puts its exit code into `code`; it throws ConfigError (kUsage) or another std::exception
/// (kCannotAccess).
/// @param jobs    runs at a time unless --jobs is given
/// @param speaks  whether this process does and prints what is not shared out: lists, studies without runs
void add_study(CLI::App& command, int& code, const Campaigner& campaigner, int jobs, bool speaks);

}  // namespace roadbalance
