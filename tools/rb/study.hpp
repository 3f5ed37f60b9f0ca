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
/// nothing where another process says the result.
using Campaigner = std::function<std::optional<std::vector<nlohmann::ordered_json>>(
    const Campaign& campaign, const Experiment& experiment)>;

/// add_study() of command.hpp with another campaigner than run_campaign().
/// @param jobs  runs at a time unless --jobs says
/// @param speaks  whether this process does and prints what is not shared out: lists, studies without runs
void add_study_over(CLI::App& app, int& code, const Campaigner& campaigner, int jobs, bool speaks);

}  // namespace roadbalance
