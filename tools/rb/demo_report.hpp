#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/recorder/recorder.hpp"
#include "sim/truth.hpp"
#include "tools/rb/bus_view.hpp"
#include "tools/rb/demo_plan.hpp"

namespace roadbalance {

/// "front left:  heavy spot 217°, ...   (truth 35.0 g 217.0°)" for all wheels, what is known of them.
std::vector<std::string> demo_lines(const BusView& view, const sim::Truth& truth);

/// "wheels" as published last with the truth beside, "nodes" as the nodes counted and as the recorder
/// counted, "drive_s" the drive that is in the record.
nlohmann::ordered_json demo_report(const BusView& view, const sim::Truth& truth, const DemoPlan& plan,
                                   const std::vector<NodeReport>& recorded);

/// kDone if every sample is in the record, kIncomplete if what is not is declared, else kAnswerIsNo.
int demo_exit_code(const nlohmann::ordered_json& report);

}  // namespace roadbalance
