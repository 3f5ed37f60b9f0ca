#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "common/bus/bus.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/recorder/recorder.hpp"
#include "host/recorder/report_json.hpp"

int main(int argc, char** argv) {
  using namespace roadbalance;
  CLI::App app("rb-recorder: records every node on the bus without loss");
  RecorderOptions options;
  options.url = default_bus_url();
  std::string folder;
  bool no_start = false;
  bool json = false;
  app.add_option("--record", folder, "folder of the recording; an existing one is continued")->required();
  app.add_option("--url", options.url, "LCM address of the bus")->capture_default_str();
  app.add_option("--nodes", options.nodes, "record only these nodes; default: every node heard");
  app.add_flag("--no-start", no_start, "claim the nodes, but leave starting them to others");
  app.add_flag("--end-with-nodes", options.end_with_nodes, "end when each of --nodes has ended");
  app.add_flag("--json", json, "print the final counts as one JSON object on standard output");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (options.end_with_nodes && options.nodes.empty()) {
    std::fprintf(stderr, "rb-recorder: --end-with-nodes needs --nodes\n");
    return 2;
  }
  options.folder = folder;
  options.start = !no_start;
  options.on_cut_tail = [](const RecordWriter::CutTail& tail) {
    std::fprintf(stderr, "rb-recorder: cut a torn tail of %ju bytes off %s; it is kept in %s\n",
                 static_cast<std::uintmax_t>(tail.cut), tail.segment.c_str(), tail.tail.c_str());
  };
  try {
    StopOnSignal signals;
    const RecorderReport report = run_recorder(signals.token(), options);
    if (json) std::printf("%s\n", to_json(report).c_str());
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb-recorder: %s\n", error.what());
    return 4;
  }
}
