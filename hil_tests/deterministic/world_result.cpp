#include <algorithm>
#include <cstring>
#include <string>

#include "hil_tests/deterministic/world.hpp"

namespace roadbalance::test {

// The truth of what every record has shown to have is needed no more.
void World::check_finished() {
  for (Host& host : hosts_) host.machine->check_finished();
  if (hosts_.size() > 1) return;
  truth_.drop_checked([this](std::int32_t node, std::int64_t epoch) {
    return hosts_.front().machine->check().checked(node, epoch);
  });
}

void World::fault_not_over(std::int64_t waited_ns) {
  const std::string over = "the drive is over for " + std::to_string(waited_ns / 1'000'000'000) + " s and ";
  for (const Host& host : hosts_)
    if (!host.machine->closed()) truth_.fault(over + "a recorder has not ended");
  for (const Node& node : nodes_)
    if (!node.left && !scenario_.is_operated())
      truth_.fault(over + "node " + std::to_string(node.machine->number()) + " holds " +
                   std::to_string(node.machine->used()) + " blocks or has not ended");
}

RunResult World::result() {
  RunResult result;
  check_set_up();
  for (Host& host : hosts_) {
    RecordCheck& check = host.machine->check();
    host.machine->kill();
    host.machine->check_record();
    for (const Asker& asker : askers_) host.machine->check_asked(asker.asked());
    check.finish(host.machine->closed() && hosts_.size() == 1);
    result.recorded += check.blocks();
    result.lost_scans += check.lost_scans();
    result.declared_scans += check.declared_scans();
    result.declared_gaps += check.declared_gaps();
    result.tail_scans += check.crash_tail_scans();
    result.longest_to_durable_s = std::max(result.longest_to_durable_s, host.machine->longest_to_durable_s());
    result.fallbacks += host.machine->fell_back() ? 1 : 0;
    result.disk_fulls += host.machine->disk_fulls();
    result.clock_events += host.machine->clock_events().found();
    result.recorder_boots += host.machine->boots();
    result.deaths_at_call += host.machine->deaths_at_call();
  }
  for (const auto& [key, epoch] : truth_.epochs()) {
    result.scans += epoch.scans;
    ++result.node_boots;
    // Of several recorders the last owner has it; what each promised was checked in its own record.
    const bool has_end = std::any_of(hosts_.begin(), hosts_.end(), [&](const Host& host) {
      return host.machine->check().is_closed(epoch.node, epoch.epoch);
    });
    if (hosts_.size() > 1 && epoch.scans > 0 && !has_end)
      truth_.fault("node " + std::to_string(epoch.node) + ": no recorder has the end of its epoch");
  }
  const std::int64_t deaths = result.recorder_boots - static_cast<std::int64_t>(hosts_.size());
  if (scenario_.expect.dies_each_time && deaths != kills_)
    truth_.fault("recorders died " + std::to_string(deaths) + " times, killed " + std::to_string(kills_) +
                 " times");
  result.clock_windows = clock_windows_;
  result.clock_covered = clock_covered_;
  result.bus_s = static_cast<double>(now_ns_) * 1e-9;
  result.blocks = truth_.blocks_sealed();
  result.lost_edges = truth_.lost_edges();
  result.lost_signals = truth_.lost_signals();
  result.sent = network_.blocks_sent();
  result.longest_pull_cleared_s = longest_pull_cleared_s_;
  if (scenario_.expect.complete && result.declared_gaps + result.tail_scans > 0)
    truth_.fault(std::to_string(result.declared_gaps) + " gaps with " +
                 std::to_string(result.declared_scans + result.tail_scans) +
                 " scans are declared where all must be there");
  if (scenario_.expect.complete && result.lost_edges + result.lost_signals > 0)
    truth_.fault(std::to_string(result.lost_edges) + " edges and " + std::to_string(result.lost_signals) +
                 " signals are lost where all must be there");
  result.faults = truth_.fault_count();
  std::string what;
  for (const std::string& fault : truth_.faults()) what += fault + "\n";
  std::strncpy(result.what.data(), what.c_str(), result.what.size() - 1);
  return result;
}

}  // namespace roadbalance::test
