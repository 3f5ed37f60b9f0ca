#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/bus/bus.hpp"
#include "common/bus/transfer_function_report.hpp"
#include "common/command_line/bus_url.hpp"
#include "common/process/stop_on_signal.hpp"
#include "common/types/clocks.hpp"
#include "common/types/scan.hpp"

// Looks at the transfer functions of each node from its first channel to every other until a signal ends it,
// which costs an analyser the cross spectra of all pairs.  Then a line of JSON: samples from one segment to
// the next, and pairs of a node and the most averages that were reported of it.

using namespace roadbalance;
using namespace std::chrono_literals;

namespace {

constexpr int kSegment = 4096;  // half of which the next one has, too

View all_pairs_of(std::int32_t node) {
  View view{.viewer = 1000 + node, .segment = kSegment};
  for (std::int32_t channel = 1; channel < kChannels; ++channel)
    view.pair.push_back({.input = {node, 0}, .output = {node, channel}});
  return view;
}

}  // namespace

int main(int argc, char** argv) {
  const StopOnSignal signals;
  CLI::App app("Looks at all transfer functions of some nodes, for the benchmark.", "bench-viewer");
  std::string url;
  std::vector<int> nodes;
  add_bus_url(app, url);
  app.add_option("--nodes", nodes, "their numbers")->required();
  CLI11_PARSE(app, argc, argv);

  Bus bus(url);
  std::map<std::int32_t, double> averages;
  bus.subscribe(kTransferFunctionChannel, [&](std::string_view, std::span<const std::uint8_t> bytes) {
    if (const auto told = decode_transfer_function(bytes))
      averages[told->pair.input.node] = std::max(averages[told->pair.input.node], told->independent_averages);
  });
  for (WallTime due = WallClock::now(); !signals.token().stop_requested(); bus.handle(50ms)) {
    if (WallClock::now() < due) continue;
    due += 500ms;
    for (const int node : nodes) bus.publish(kViewChannel, encode(all_pairs_of(node)));
  }
  const nlohmann::json shown{{"hop", kSegment / 2}, {"averages", averages}};
  std::printf("%s\n", shown.dump().c_str());
  return 0;
}
