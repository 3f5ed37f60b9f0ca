#include "host/recorder/report_json.hpp"

#include <nlohmann/json.hpp>

namespace roadbalance {

std::string to_json(const RecorderReport& report) {
  nlohmann::json nodes = nlohmann::json::array();
  for (const auto& n : report.node)
    nodes.push_back({{"node", n.node},
                     {"epoch", n.epoch},
                     {"samples_sent", n.samples_sent},
                     {"samples_recorded", n.samples_recorded},
                     {"gaps", n.gaps},
                     {"repaired", n.repaired},
                     {"blocks", n.blocks},
                     {"ended", n.ended}});
  return nlohmann::json{{"nodes", nodes},
                        {"blocks_refused", report.blocks_refused},
                        {"rival_heartbeats", report.rival_heartbeats},
                        {"foreign_nodes", report.foreign},
                        {"unsent", report.unsent}}
      .dump();
}

}  // namespace roadbalance
