#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/recorder/recorder.hpp"
#include "sim/truth.hpp"
#include "tools/demonstration/demo_plan.hpp"
#include "tools/views/bus_view.hpp"

namespace roadbalance {

/// "front left:  heavy spot 217°, ...   (truth 35.0 g 217.0°)" for all wheels, what is known of them.
std::vector<std::string> demo_lines(const BusView& view, const sim::Truth& truth);

/// "wheels" as published last with the truth beside, "nodes" as the nodes counted and as the recorder
/// counted, "drive_s" the drive that is in the record.
nlohmann::ordered_json demo_report(const BusView& view, const sim::Truth& truth, const DemoPlan& plan,
                                   const std::vector<NodeReport>& recorded);

/// Why no wheel at all was identified; empty if one was.
std::string demo_obstacle(const BusView& view);

/// kDone if every sample is in the record and a wheel was identified, kIncomplete if only samples are missing
/// and all of them are declared, else kAnswerIsNo.
int demo_exit_code(const nlohmann::ordered_json& report);

}  // namespace roadbalance
