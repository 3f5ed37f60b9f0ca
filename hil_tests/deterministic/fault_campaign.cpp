#include "hil_tests/deterministic/fault_campaign.hpp"

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <map>
#include <system_error>

#include "hil_tests/deterministic/world.hpp"

namespace roadbalance::test {
namespace {

// The message of a worker when it begins a seed and when it has its result.  Shorter than PIPE_BUF: whole or
// not.
struct Message {
  int worker = 0;
  bool finished = false;
  RunResult result;
};
static_assert(sizeof(Message) < 4096);

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

void put_fault(RunResult& result, const std::string& what) {
  ++result.faults;
  const std::string all = result.what.data() + what + "\n";
  std::strncpy(result.what.data(), all.c_str(), result.what.size() - 1);
}

/// How long a run is.
double length_s(const FaultScenario& scenario, const CampaignOptions& options) {
  return options.seconds ? std::max(*options.seconds, scenario.least_seconds) : scenario.seconds;
}

RunResult run_one(const FaultScenario& scenario, std::uint64_t seed, const CampaignOptions& options) {
  const double before_s = processor_seconds();
  RunResult result;
  try {
    World world(scenario, seed, length_s(scenario, options));
    result = world.run();
    result.processor_s = processor_seconds() - before_s;
    if (!options.dump.empty()) world.dump(options.dump);
  } catch (const std::exception& error) {
    put_fault(result, std::string("ended by an exception: ") + error.what());
  }
  result.seed = seed;
  return result;
}

void say(int pipe, const Message& message) {
  if (::write(pipe, &message, sizeof message) != sizeof message) std::_Exit(3);
}

// Each worker is a process of its own: a failed assertion of the product ends it and is a result, too.
[[noreturn]] void work(int worker, int pipe, const FaultScenario& scenario, const CampaignOptions& options) {
  for (std::int64_t k = worker; k < options.seeds; k += options.jobs) {
    Message message{.worker = worker, .finished = false, .result = {}};
    message.result.seed = options.first_seed + static_cast<std::uint64_t>(k);
    say(pipe, message);
    message.result = run_one(scenario, message.result.seed, options);
    message.finished = true;
    say(pipe, message);
  }
  std::fflush(nullptr);
  std::_Exit(0);
}

bool read_message(int pipe, Message& message) {
  std::size_t got = 0;
  while (got < sizeof message) {
    const ssize_t n = ::read(pipe, reinterpret_cast<char*>(&message) + got, sizeof message - got);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    got += static_cast<std::size_t>(n);
  }
  return true;
}

struct Worker {
  pid_t process = -1;
  std::optional<std::uint64_t> seed;  // under way
};

std::vector<Worker> start_workers(const int (&ends)[2], const FaultScenario& scenario,
                                  const CampaignOptions& options) {
  std::vector<Worker> workers;
  for (int w = 0; w < options.jobs; ++w) {
    const pid_t process = ::fork();
    if (process < 0) throw std::system_error(errno, std::generic_category(), "fork");
    if (process == 0) {
      ::close(ends[0]);
      work(w, ends[1], scenario, options);
    }
    workers.push_back({.process = process, .seed = std::nullopt});
  }
  return workers;
}

}  // namespace

std::vector<RunResult> run_seeds(const FaultScenario& scenario, const CampaignOptions& options) {
  int ends[2];
  if (::pipe(ends) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  std::fflush(nullptr);
  auto workers = start_workers(ends, scenario, options);
  ::close(ends[1]);
  std::vector<RunResult> results;
  for (Message message; read_message(ends[0], message);) {
    auto& worker = workers[static_cast<std::size_t>(message.worker)];
    worker.seed.reset();
    if (message.finished)
      results.push_back(message.result);
    else
      worker.seed = message.result.seed;
  }
  ::close(ends[0]);
  for (const Worker& worker : workers) {
    int status = 0;
    ::waitpid(worker.process, &status, 0);
    if (!worker.seed) continue;
    RunResult died;
    died.seed = *worker.seed;
    put_fault(died, "the run was ended by " + (WIFSIGNALED(status)
                                                   ? std::string("signal ") + ::strsignal(WTERMSIG(status))
                                                   : std::string("its process")));
    results.push_back(died);
  }
  std::sort(results.begin(), results.end(), [](const auto& a, const auto& b) { return a.seed < b.seed; });
  return results;
}

namespace {

double sends_per_block(const RunResult& run) {
  return run.blocks == 0 ? 0 : static_cast<double>(run.sent) / static_cast<double>(run.blocks);
}

void hold_against(const FaultScenario& scenario, const CampaignOptions& options, RunResult& run) {
  const Expectation& expect = scenario.expect;
  const auto limit = [&run](const char* what, double is, const std::optional<double>& most) {
    if (most && is > *most)
      put_fault(run,
                std::string(what) + " is " + std::to_string(is) + ", allowed is " + std::to_string(*most));
  };
  // In a run shorter than the scenario's perhaps no recording is asked for.
  const bool is_short = length_s(scenario, options) < scenario.seconds;
  if (run.blocks == 0 && !(scenario.is_operated() && is_short)) put_fault(run, "nothing was sealed");
  const double coverage = run.clock_windows == 0 ? 0
                                                 : static_cast<double>(run.clock_covered) /
                                                       static_cast<double>(run.clock_windows);
  if (expect.clock_coverage && coverage < *expect.clock_coverage)
    put_fault(run, "the stated uncertainty of clocks covers " + std::to_string(coverage) + " of the windows");
  limit("sends per block", sends_per_block(run), expect.sends_per_block);
  const auto measured = [&limit, &run](const char* what, double is, const std::optional<double>& most) {
    if (most && is == 0) put_fault(run, std::string(what) + " has a limit and was not measured");
    limit(what, is, most);
  };
  measured("longest sealed to durable, s,", run.longest_to_durable_s, expect.to_durable_s);
  measured("backlog gone after a pull, s,", run.longest_pull_cleared_s, expect.pull_cleared_s);
}

void add(const RunResult& run, RunResult& all) {
  all.bus_s += run.bus_s;
  all.processor_s += run.processor_s;
  all.blocks += run.blocks;
  all.sent += run.sent;
  all.lost_scans += run.lost_scans;
  all.declared_scans += run.declared_scans;
  all.tail_scans += run.tail_scans;
  all.lost_edges += run.lost_edges;
  all.late_starts += run.late_starts;
  all.lost_signals += run.lost_signals;
  all.recorder_boots += run.recorder_boots;
  all.deaths_at_call += run.deaths_at_call;
  all.node_boots += run.node_boots;
  all.fallbacks += run.fallbacks;
  all.disk_fulls += run.disk_fulls;
  all.clock_events += run.clock_events;
  all.clock_windows += run.clock_windows;
  all.clock_covered += run.clock_covered;
  all.faults += run.faults;
  all.longest_to_durable_s = std::max(all.longest_to_durable_s, run.longest_to_durable_s);
  all.longest_pull_cleared_s = std::max(all.longest_pull_cleared_s, run.longest_pull_cleared_s);
}

/// A cable is out just while a start is announced in one run of five.
constexpr int kEnoughForLateStarts = 20;

}  // namespace

Summary summarise(const FaultScenario& scenario, const std::vector<RunResult>& results,
                  const CampaignOptions& options) {
  Summary summary;
  summary.scenario = scenario.name;
  for (RunResult run : results) {
    hold_against(scenario, options, run);
    add(run, summary.all);
    summary.worst_sends_per_block = std::max(summary.worst_sends_per_block, sends_per_block(run));
    ++summary.runs;
    if (run.faults > 0) summary.failed.push_back(run);
  }
  if (summary.all.blocks == 0) summary.missed = "nothing was sealed";
  if (scenario.expect.dies_at_calls && summary.all.deaths_at_call < summary.runs)
    summary.missed = "recorders died before a call of their disk " +
                     std::to_string(summary.all.deaths_at_call) + " times only";
  if (scenario.expect.loses_edges && summary.all.lost_edges == 0)
    summary.missed = "no edge was lost: that they are declared was not tried";
  if (scenario.expect.loses_signals && summary.all.lost_signals == 0)
    summary.missed = "no signal was lost: that they are declared was not tried";
  if (scenario.expect.starts_late && summary.runs >= kEnoughForLateStarts && summary.all.late_starts == 0)
    summary.missed = "no node began late: that it is declared was not tried";
  if (scenario.expect.falls_back && 2 * summary.all.fallbacks < summary.runs)
    summary.missed =
        "recorders went to their fallback folder " + std::to_string(summary.all.fallbacks) + " times only";
  if (scenario.plans(FaultKind::kDiskFull) && summary.all.disk_fulls == 0)
    summary.missed = "no recorder waited for space on its disk";
  if (scenario.slow_syncs > 0 && summary.all.longest_to_durable_s < scenario.slow_sync.shortest_s)
    summary.missed = "no sync was slow";
  if (summary.blocks_per_s() < options.least_blocks_per_s)
    summary.missed = std::to_string(std::lround(summary.blocks_per_s())) + " blocks a second, wanted are " +
                     std::to_string(std::lround(options.least_blocks_per_s));
  if (summary.runs != options.seeds)
    summary.missed = "of " + std::to_string(options.seeds) + " seeds " + std::to_string(summary.runs) +
                     " have a result: a process that ran them is gone";
  return summary;
}

std::string line_of(const Summary& summary) {
  const RunResult& all = summary.all;
  char text[400];
  std::snprintf(text, sizeof text,
                "%-22s %5lld seeds %6.0f s of bus %9lld blocks  lost %lld  declared %lld + tails %lld scans  "
                "sends %.3f  durable %.2f s  pull %.2f s  boots %lld+%lld, %lld at calls  %4.0f k blocks/s",
                summary.scenario.c_str(), static_cast<long long>(summary.runs), all.bus_s,
                static_cast<long long>(all.blocks), static_cast<long long>(all.lost_scans),
                static_cast<long long>(all.declared_scans), static_cast<long long>(all.tail_scans),
                summary.worst_sends_per_block, all.longest_to_durable_s, all.longest_pull_cleared_s,
                static_cast<long long>(all.recorder_boots), static_cast<long long>(all.node_boots),
                static_cast<long long>(all.deaths_at_call), summary.blocks_per_s() * 1e-3);
  if (all.clock_windows == 0) return text;
  char clocks[120];
  std::snprintf(clocks, sizeof clocks, "  clocks covered %.5f of %lld, %lld events recorded",
                static_cast<double>(all.clock_covered) / static_cast<double>(all.clock_windows),
                static_cast<long long>(all.clock_windows), static_cast<long long>(all.clock_events));
  return std::string(text) + clocks;
}

}  // namespace roadbalance::test
