#include "tools/doctor/roll_call.hpp"

#include <algorithm>
#include <span>
#include <string_view>

#include "common/bus/recorder_status.hpp"
#include "common/types/text_crc.hpp"

namespace roadbalance {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kMostRecorders = 8;

/// "front (1)", or "1" of one that the vehicle does not have.
std::string name_of(std::int32_t number, const VehicleConfig* vehicle) {
  const NodeConfig* const node = vehicle != nullptr ? vehicle->node_with_id(number) : nullptr;
  return node != nullptr ? node->name + " (" + std::to_string(number) + ")" : std::to_string(number);
}

std::string list_of(const std::set<std::int32_t>& numbers, const VehicleConfig* vehicle) {
  std::string list;
  for (const std::int32_t number : numbers) list += (list.empty() ? "" : ", ") + name_of(number, vehicle);
  return list;
}

}  // namespace

RollCall::RollCall(const std::string& url) : url_(url), bus_(url) {
  bus_.subscribe("RB_HEARTBEAT_.*", [this](std::string_view, Bytes bytes) {
    if (const auto beat = decode_heartbeat(bytes)) take(*beat);
  });
  bus_.subscribe(kRecorderChannel, [this](std::string_view, Bytes bytes) {
    const auto status = decode_recorder_status(bytes);
    if (status && recorders_.size() < kMostRecorders) recorders_.insert(status->recorder);
  });
  listen(std::chrono::milliseconds(0));
}

void RollCall::listen(std::chrono::milliseconds duration) {
  using std::chrono::steady_clock;
  const auto end = steady_clock::now() + duration;
  do {
    bus_.handle(std::chrono::ceil<std::chrono::milliseconds>(end - steady_clock::now()));
  } while (steady_clock::now() < end);
  for (const std::int32_t node : bus_.nodes_of_other_versions())
    if (of_other_versions_.size() < kMostNodes) of_other_versions_.insert(node);
}

// Input from the bus is bounded.
void RollCall::take(const Heartbeat& beat) {
  if (!nodes_.contains(beat.node) && nodes_.size() >= kMostNodes) return;
  Node& node = nodes_[beat.node];
  node.vehicle_crc32c = beat.vehicle_crc32c;
  if (beat.is_over()) return;
  // Two nodes are heard in turns; one that was started again is not heard of before.
  node.is_two = node.is_two || (beat.epoch != node.newest && node.epochs.contains(beat.epoch));
  node.newest = beat.epoch;
  if (node.epochs.size() < kMostEpochs) node.epochs.insert(beat.epoch);
}

std::set<std::int32_t> RollCall::nodes() const {
  std::set<std::int32_t> numbers = of_other_versions_;
  for (const auto& [number, node] : nodes_) numbers.insert(number);
  return numbers;
}

std::vector<Finding> RollCall::findings(const VehicleConfig* vehicle, const std::string& file) const {
  std::vector<Finding> findings;
  const auto ill = [&](const char* name, const std::string& sentence, const std::string& remedy) {
    findings.push_back({name, Finding::kIll, sentence, remedy});
  };
  if (!of_other_versions_.empty())
    ill("other_version",
        "Of another version of the wire: node " + list_of(of_other_versions_, vehicle) +
            "; nothing of it is recorded.",
        "install the same release of roadbalance on every computer of this bus");
  for (const auto& [number, node] : nodes_)
    if (node.is_two)
      ill("two_nodes", "Two nodes have one number: " + name_of(number, vehicle) + ".",
          "pgrep -a rb-node  # on each computer: end one of them, or give it an id of its own in the vehicle "
          "file");
  const std::set<std::int32_t> heard = nodes();
  if (vehicle != nullptr)
    add_strangers(*vehicle, file, findings);
  else if (heard.empty())
    findings.push_back({"nodes", Finding::kNote, "No node was heard on " + url_ + ".",
                        "rb-node --vehicle vehicle.toml --node NAME --url '" + url_ + "'"});
  if (findings.empty())
    findings.push_back(
        {"nodes", Finding::kWell, "Nodes heard on the bus: " + list_of(heard, vehicle) + ".", ""});
  add_recorders(file, findings);
  return findings;
}

void RollCall::add_strangers(const VehicleConfig& vehicle, const std::string& file,
                             std::vector<Finding>& findings) const {
  std::set<std::int32_t> strangers = nodes(), differ;
  for (const NodeConfig& node : vehicle.node) {
    if (strangers.erase(node.id) == 0)
      findings.push_back({"nodes", Finding::kIll,
                          "Node " + name_of(node.id, &vehicle) + " was not heard on " + url_ + ".",
                          "rb-node --vehicle " + file + " --node " + node.name + " --url '" + url_ +
                              "'  # on its computer"});
    const auto known = nodes_.find(node.id);
    if (known != nodes_.end() && known->second.vehicle_crc32c != crc32c(vehicle.text)) differ.insert(node.id);
  }
  if (!strangers.empty())
    findings.push_back({"strangers", Finding::kNote,
                        "Heard, and not in " + file + ": node " + list_of(strangers, nullptr) + ".",
                        "rb watch  # says what it does; a [[node]] of that id makes it one of the car's"});
  if (!differ.empty())
    findings.push_back(
        {"vehicle_file", Finding::kNote,
         "By another vehicle file than " + file + " measures: node " + list_of(differ, &vehicle) + ".",
         "scp " + file + " COMPUTER:  # to each, and start it anew; or rb vehicle"});
}

void RollCall::add_recorders(const std::string& file, std::vector<Finding>& findings) const {
  if (recorders_.empty())
    findings.push_back({"recorder", Finding::kNote, "No recorder was heard.",
                        "rb-recorder --recordings FOLDER --vehicle " +
                            (file.empty() ? "vehicle.toml" : file) + " --url '" + url_ + "'"});
  else if (recorders_.size() > 1)
    findings.push_back({"recorder", Finding::kNote,
                        std::to_string(recorders_.size()) + " recorders were heard: a node obeys only one.",
                        "pgrep -a rb-recorder  # on each computer: one is to stay"});
  else
    findings.push_back({"recorder", Finding::kWell, "A recorder is there.", ""});
}

}  // namespace roadbalance
