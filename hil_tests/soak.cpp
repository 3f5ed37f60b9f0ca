#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/bus/process_port.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "common/types/clocks.hpp"
#include "hil_tests/bus_watch.hpp"
#include "hil_tests/memory_trend.hpp"
#include "hil_tests/program.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance::test {
namespace {

struct Options {
  double minutes = 30;
  double rate = 20;
  double settle_s = 60;
  double sample_s = 1;
  double most_growth_mb = 1;
  double least_share = 0.9;
};

struct Watched {
  std::string name;
  Program program;
  MemoryTrend memory;
};

/// A recorder and two nodes on a bus of their own, for as long as asked.
class Soak {
 public:
  explicit Soak(const Options& options) : options_(options), bus_(url_) {
    start("recorder", "rb-recorder", {"--record", record_, "--url", url_});
    for (const char* node : {"front", "rear"})
      start(node, "rb-node",
            {"--vehicle", source_path("sim/demo/vehicle.toml"), "--node", node, "--url", url_, "--front-end",
             "sim:?seconds=1000000&rate=" + std::to_string(options.rate)});
  }

  /// From when both nodes measure on; a node that does not would not end with the recorder.
  void run() {
    if (!bus_.wait([&] { return bus_.ack(1).durable > 0 && bus_.ack(2).durable > 0; }))
      throw std::runtime_error("nothing is recorded of one of the nodes");
    for (const std::int32_t node : {1, 2}) sampled_before_[node] = bus_.heartbeat(node).scans_sampled;
    const auto begin = WallClock::now();
    for (double elapsed_s = 0; elapsed_s < 60 * options_.minutes; elapsed_s_ = elapsed_s) {
      bus_.listen(options_.sample_s);
      elapsed_s = std::chrono::duration<double>(WallClock::now() - begin).count();
      for (auto& watched : watched_) {
        const auto bytes = own_memory_bytes(watched.program.pid());
        if (!bytes || watched.program.exit_code(0)) throw std::runtime_error(watched.name + " has ended");
        watched.memory.add(elapsed_s, *bytes);
      }
    }
  }

  /// Prints what was measured.  True if all is well.
  bool report() {
    bool well = true;
    for (const std::int32_t node : {1, 2}) {
      const Heartbeat heartbeat = bus_.heartbeat(node);
      const std::int64_t durable = bus_.ack(node).durable;
      std::printf("node %d: %lld blocks durable, %lld scans missing\n", node, static_cast<long long>(durable),
                  static_cast<long long>(heartbeat.scans_missing));
      well = well && durable > 0 && heartbeat.scans_missing == 0 && kept_pace(heartbeat);
    }
    for (const auto& watched : watched_) {
      constexpr double kMB = 1e6;
      const double growth_mb = static_cast<double>(watched.memory.growth_bytes()) / kMB;
      std::printf("%s: %.2f MB when settled, grew by %.2f MB\n", watched.name.c_str(),
                  static_cast<double>(watched.memory.settled_bytes()) / kMB, growth_mb);
      well = well && watched.memory.has_settled() && growth_mb < options_.most_growth_mb;
    }
    return well;
  }

  /// Ends the recorder and by that the nodes.  True if the record is complete.
  bool end() {
    watched_.front().program.signal(SIGTERM);
    for (auto& watched : watched_)
      if (watched.program.exit_code(BusWatch::kPatience_s) != 0)
        throw std::runtime_error(watched.name + " did not end well");
    const Verification verification = verify_record(record_);
    std::printf("the record: %s\n", verdict_text(verification).c_str());
    return verification.verdict == Verdict::kComplete && verification.epoch.size() == 2;
  }

 private:
  /// At any rate but 1 a simulated device waits: a machine that is too slow soaks less than it reports.
  bool kept_pace(const Heartbeat& heartbeat) const {
    const double asked = options_.rate * vehicle_.node.front().rate_hz * elapsed_s_;
    const double share =
        static_cast<double>(heartbeat.scans_sampled - sampled_before_.at(heartbeat.node)) / asked;
    std::printf("node %d: %.3f of the scans asked for\n", heartbeat.node, share);
    if (share >= options_.least_share) return true;
    std::fprintf(stderr, "rb-soak: this machine is too slow for rate %g\n", options_.rate);
    return false;
  }
  void start(const std::string& name, const std::string& program, const std::vector<std::string>& arguments) {
    watched_.push_back({name, Program(program, arguments), MemoryTrend(options_.settle_s)});
  }

  const Options options_;
  const VehicleConfig vehicle_ = VehicleConfig::read_file(source_path("sim/demo/vehicle.toml"));
  const TemporaryDirectory work_;
  const std::filesystem::path record_ = work_.path() / "record";
  const std::string url_ = bus_url_on_port(process_port());
  BusWatch bus_;
  double elapsed_s_ = 0;
  std::map<std::int32_t, std::int64_t> sampled_before_;  // by node
  std::vector<Watched> watched_;                         // the recorder first
};

}  // namespace
}  // namespace roadbalance::test

int main(int argc, char** argv) {
  CLI::App app("rb-soak: records two simulated nodes for a long time and watches the programs' memory");
  roadbalance::test::Options options;
  app.add_option("--minutes", options.minutes)->check(CLI::Range(0.01, 1e5))->capture_default_str();
  app.add_option("--rate", options.rate, "times real time")
      ->check(CLI::Range(0.001, 1e6))
      ->capture_default_str();
  app.add_option("--settle", options.settle_s, "seconds that count as the start")->capture_default_str();
  app.add_option("--growth-mb", options.most_growth_mb, "MB allowed after the start")->capture_default_str();
  app.add_option("--least-share", options.least_share, "of the scans that the rate asks for")
      ->capture_default_str();
  app.footer(
      "Needs RB_BIN and RB_SOURCE as the tests do.  Exit codes: 0 flat and complete, 1 it grew, lost or "
      "was too slow, 4 it failed.");
  CLI11_PARSE(app, argc, argv);
  try {
    roadbalance::test::Soak soak(options);
    soak.run();
    const bool well = soak.report();
    const bool complete = soak.end();
    return well && complete ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb-soak: %s\n", error.what());
    return 4;
  }
}
