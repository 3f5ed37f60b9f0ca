#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>

#include "common/bus/absence.hpp"
#include "common/command_line/bus_url.hpp"
#include "common/command_line/exit_code.hpp"
#include "common/command_line/manual.hpp"
#include "common/command_line/run_program.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/process/heap.hpp"
#include "common/process/service_notify.hpp"
#include "common/process/stop_on_signal.hpp"
#include "common/record/folder.hpp"
#include "common/record/new_name.hpp"
#include "host/recorder/control/operate.hpp"
#include "host/recorder/control/session_state.hpp"
#include "host/recorder/recorder.hpp"
#include "host/recorder/status_line.hpp"

namespace {

using namespace roadbalance;

/// {"nodes":[{"node":1,"epoch":...,"samples_sent":...,"samples_recorded":...,"gaps":...,"repaired":...,...}],
/// "absent":[{"node":2,"text":"never came"}],...}
std::string report_json(const RecorderReport& report) {
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
  nlohmann::json absent = nlohmann::json::array();
  for (const Absence& absence : report.absence)
    absent.push_back({{"node", absence.node}, {"text", words(absence)}});
  return nlohmann::json{{"nodes", nodes},
                        {"absent", absent},
                        {"blocks_refused", report.blocks_refused},
                        {"rival_heartbeats", report.rival_heartbeats},
                        {"foreign_nodes", report.foreign},
                        {"unsent", report.unsent}}
      .dump();
}

/// Of the recording that has ended: who was absent, for people.
void print_absences(const RecorderReport& report, const std::vector<ExpectedNode>& expected) {
  for (const Absence& absence : report.absence) {
    const auto node = std::ranges::find(expected, absence.node, &ExpectedNode::number);
    const std::string name = node == expected.end() ? "" : node->name;
    std::fprintf(stderr, "rb-recorder: %s %s\n", node_words(absence.node, name).c_str(),
                 words(absence).c_str());
  }
}

/// As they are typed.
struct DiskSizes {
  double segment_mib = 64;
  double keep_gib = 0;
  std::int64_t reserve_mib = RecorderOptions().reserve_bytes >> 20;

  void apply_to(RecorderOptions& options) const {
    options.segment_bytes = static_cast<std::uint64_t>(segment_mib * (1 << 20));
    options.keep_bytes = static_cast<std::int64_t>(keep_gib * (1 << 30));
    options.reserve_bytes = reserve_mib << 20;
  }
};

void add_disk_options(CLI::App& app, RecorderOptions& options, DiskSizes& sizes) {
  app.add_option("--fallback", options.fallback, "folder to go on in when the disk of the first one fails");
  app.add_option("--segment-mib", sizes.segment_mib, "size of a segment of the recording")
      ->check(number_within(0.25, 4096.0))
      ->capture_default_str();
  app.add_option("--keep-gib", sizes.keep_gib,
                 "delete the oldest finished segments beyond so much; default: keep all")
      ->check(number_within(0.001, 1e6));
  app.add_option("--reserve-mib", sizes.reserve_mib, "of the disk, not for measuring")
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str();
  app.add_option("--power", options.power,
                 "say when the supply is gone, and close the segment: supply:NAME or gpio:CHIP:LINE[:low]");
}

/// Those of the command line, or else of the vehicle file.  @throws ConfigError
std::vector<ExpectedNode> expected_nodes(const std::vector<std::int32_t>& chosen,
                                         const std::string& vehicle) {
  std::vector<ExpectedNode> expected;
  for (const std::int32_t number : chosen) expected.push_back({.number = number});
  if (!chosen.empty() || vehicle.empty()) return expected;
  for (const NodeConfig& node : VehicleConfig::read_file(vehicle).node)
    expected.push_back({.number = node.id, .name = node.name});
  return expected;
}

// A supervisor hears that we live only when both the link and the writer have turned since.
void notify_supervisor(ServiceNotify& notify, RecorderOptions& options) {
  const auto ready = std::make_shared<std::atomic<bool>>(false);
  options.on_alive = [&notify, ready](const RecorderStatus& status) {
    if (!ready->exchange(true)) notify.ready();
    notify.feed();
    const auto alarm = alarms(status);
    notify.status(alarm.empty() ? status_line(status) : words(alarm.front()));
  };
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Records every node on the bus without loss.", "rb-recorder");
  RecorderOptions options;
  std::string folder;
  bool no_start = false;
  bool json = false;
  DiskSizes sizes;
  std::string recordings;
  std::optional<std::string> start;
  auto* record = app.add_option("--record", folder, "folder of the recording; an existing one is continued");
  auto* operated =
      app.add_option("--recordings", recordings,
                     "folder of recordings that start and stop on request: rb start, or the page");
  operated->excludes(record);
  std::string vehicle;
  app.add_option("--vehicle", vehicle,
                 "vehicle.toml whose nodes are to be recorded; with --recordings requests may change it, and "
                 "choose another "
                 "in its folder");
  app.add_option("--start", start, "with --recordings: begin one of this name at once")->needs(operated);
  add_bus_url(app, options.url);
  app.add_option("--nodes", options.nodes, "record only these nodes; default: every node heard")
      ->check(CLI::Range(1, 9999));
  app.add_flag("--no-start", no_start, "claim the nodes, but leave starting them to others")
      ->excludes(operated);
  app.add_flag("--end-with-nodes", options.end_with_nodes, "end when each of --nodes has ended")
      ->excludes(operated);
  app.add_flag("--json", json, "print the final counts as one JSON object on standard output");
  add_disk_options(app, options, sizes);
  add_version(app);
  add_manual(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return report_failure(app, error);
  }
  if (folder.empty() && recordings.empty()) {
    std::fprintf(stderr, "rb-recorder: --record or --recordings must say where to\n");
    return 2;
  }
  if (const std::string fault = start ? fault_of_new_name(*start) : ""; !fault.empty()) {
    report("rb-recorder", "--start " + *start + ": " + fault);
    return 2;
  }
  if (options.end_with_nodes && options.nodes.empty()) {
    std::fprintf(stderr, "rb-recorder: --end-with-nodes needs --nodes\n");
    return 2;
  }
  options.folder = folder;
  options.start = !no_start;
  options.keeps_awake = true;
  sizes.apply_to(options);
  options.on_cut_tail = [](const RecordWriter::CutTail& tail) {
    report("rb-recorder", "cut a torn tail of " + std::to_string(tail.cut) + " bytes off " +
                              tail.segment.string() + "; it is kept in " + tail.tail.string());
  };
  options.on_warning = [](const std::string& sentence) { report("rb-recorder", sentence); };
  try {
    keep_heap();
    StopOnSignal signals;
    ServiceNotify notify;
    if (notify.has_supervisor()) notify_supervisor(notify, options);
    const std::stop_callback announce_stop(signals.token(), [&notify] { notify.stopping(); });
    if (!folder.empty() && !path_exists(folder)) expect_new_name(folder);
    options.expected = expected_nodes(options.nodes, recordings.empty() ? vehicle : "");
    const RecorderReport report =
        recordings.empty()
            ? run_recorder(signals.token(), options)
            : operate(signals.token(),
                      {.recorder = options, .recordings = recordings, .vehicle = vehicle, .start = start});
    if (json) std::printf("%s\n", report_json(report).c_str());
    // With --recordings, rb stop answers for each of them, and the end of the service is none of theirs.
    if (!recordings.empty()) return kDone;
    print_absences(report, options.expected);
    return report.absence.empty() ? kDone : kIncomplete;
  } catch (const std::invalid_argument& error) {
    return report_failure(app, ConfigError(error.what()));
  } catch (const std::exception& error) {
    return report_failure(app, error);
  }
}
