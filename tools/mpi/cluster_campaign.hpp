#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "tools/study/campaign.hpp"

namespace roadbalance {

/// run_campaign() with its seeds dealt out in turn to all processes of MPI_COMM_WORLD.  The results come back
/// to the first as text, so no folder need be shared; the others get nothing.
/// @throws std::runtime_error in every process if a run fails in one
std::optional<std::vector<nlohmann::ordered_json>> run_campaign_on_cluster(const Campaign& campaign,
                                                                           const Experiment& experiment);

}  // namespace roadbalance
