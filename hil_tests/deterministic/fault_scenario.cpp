#include "hil_tests/deterministic/fault_scenario.hpp"

#include <filesystem>
#include <system_error>

#include "common/config/section.hpp"
#include "common/record/file.hpp"

namespace roadbalance::test {
namespace {

constexpr Range kShare{0, 1};
constexpr Range kSeconds{0, 1e6};

Span read_span(Section& table, const std::string& key, Span otherwise) {
  const auto two = table.numbers_or(key, 2, kSeconds, {otherwise.shortest_s, otherwise.longest_s});
  if (two[0] > two[1]) table.fail(key, "the first is the shortest");
  return {two[0], two[1]};
}

void read_network(Section table, FaultScenario& scenario) {
  const double loss = table.number_or("loss", kShare, 0);
  scenario.loss_to_host = table.number_or("loss_to_host", kShare, loss);
  scenario.loss_to_node = table.number_or("loss_to_node", kShare, loss);
  scenario.duplicates = table.number_or("duplicates", kShare, 0);
  scenario.reordered = table.number_or("reordered", kShare, scenario.reordered);
  table.finish();
}

void read_disk(Section table, FaultScenario& scenario) {
  scenario.segment_mib = table.number_or("segment_mib", {0.1, 1024}, scenario.segment_mib);
  scenario.keep_mib = table.number_or("keep_mib", {0, 4096}, 0);
  scenario.fallback = table.boolean_or("fallback", false);
  scenario.slow_syncs = table.number_or("slow_syncs", kShare, 0);
  scenario.slow_sync = read_span(table, "slow_sync_s", scenario.slow_sync);
  table.finish();
}

PlannedFault read_fault(Section& table) {
  PlannedFault fault;
  fault.kind = static_cast<FaultKind>(table.choice("what", {kFaultNames.begin(), kFaultNames.end()}));
  fault.times = table.number_or("times", {1, 1e6}, 1);
  const auto within = table.numbers_or("within", 2, kShare, {fault.from, fault.to});
  fault.from = within[0];
  fault.to = within[1];
  if (fault.from > fault.to) table.fail("within", "the first is the earliest");
  fault.lasting = read_span(table, "lasting_s", fault.lasting);
  fault.direction = static_cast<Direction>(table.choice_or("direction", {"both", "to_host", "to_node"}, 0));
  fault.all_nodes = table.boolean_or("all_nodes", true);
  fault.strength = table.number_or("strength", kShare, 1);
  table.finish();
  return fault;
}

std::string read_whole(const std::filesystem::path& file) {
  const auto text = read_text(file);
  if (!text)
    throw std::system_error(std::make_error_code(std::errc::no_such_file_or_directory), file.string());
  return *text;
}

std::optional<double> read_limit(Section& table, const std::string& key) {
  if (!table.has(key)) return std::nullopt;
  return table.number(key, kPositive);
}

Expectation read_expectation(Section table) {
  Expectation expect;
  expect.complete = table.boolean_or("complete", false);
  expect.absences = table.boolean_or("absences", false);
  expect.falls_back = table.boolean_or("falls_back", false);
  expect.loses_edges = table.boolean_or("loses_edges", false);
  expect.starts_late = table.boolean_or("starts_late", false);
  expect.loses_signals = table.boolean_or("loses_signals", false);
  expect.dies_at_calls = table.boolean_or("dies_at_calls", false);
  expect.dies_each_time = table.boolean_or("dies_each_time", false);
  expect.sends_per_block = read_limit(table, "most_sends_per_block");
  expect.to_durable_s = read_limit(table, "longest_to_durable_s");
  expect.pull_cleared_s = read_limit(table, "longest_pull_cleared_s");
  expect.clock_coverage = read_limit(table, "least_clock_coverage");
  table.finish();
  return expect;
}

}  // namespace

FaultScenario FaultScenario::read_file(const std::string& path) {
  Section table = Section::parse_file(path);
  FaultScenario scenario;
  scenario.name = std::filesystem::path(path).stem().string();
  scenario.seconds = table.number_or("seconds", {1, 1e6}, scenario.seconds);
  scenario.least_seconds = table.number_or("least_seconds", {1, 1e6}, scenario.least_seconds);
  scenario.nodes = static_cast<int>(table.integer_or("nodes", 1, 16, scenario.nodes));
  scenario.hosts = static_cast<int>(table.integer_or("recorders", 1, 4, scenario.hosts));
  scenario.second_starts = table.number_or("second_recorder_starts", kShare, scenario.second_starts);
  scenario.same_ids = table.boolean_or("same_ids", false);
  scenario.rate_hz = table.number_or("rate_hz", {100, 40'000}, scenario.rate_hz);
  scenario.ring_mib = table.number_or("ring_mib", {0.1, 64}, scenario.ring_mib);
  scenario.spool_mib = table.number_or("spool_mib", {0, 1024}, 0);
  scenario.clocks = table.boolean_or("clocks", false);
  if (table.has("vehicle"))
    scenario.vehicle = read_whole(std::filesystem::path(path).parent_path() / table.text("vehicle"));
  if (auto network = table.section_if("network")) read_network(std::move(*network), scenario);
  if (auto disk = table.section_if("disk")) read_disk(std::move(*disk), scenario);
  for (Section& fault : table.sections("fault")) scenario.faults.push_back(read_fault(fault));
  if (auto expect = table.section_if("expect")) scenario.expect = read_expectation(std::move(*expect));
  table.finish();
  return scenario;
}

}  // namespace roadbalance::test
