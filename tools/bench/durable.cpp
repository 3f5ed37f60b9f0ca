#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/control_messages.hpp"
#include "common/command_line/bus_url.hpp"
#include "common/process/stop_on_signal.hpp"
#include "common/types/clocks.hpp"

// Listens to blocks and to what the recorder reports of them until a signal ends it: how long each block
// waited, from its first way over the bus, which follows its seal at once, until it was called durable.  Then
// a line of JSON.

using namespace roadbalance;
using namespace std::chrono_literals;

namespace {

struct Sent {
  std::int64_t sequence;
  WallTime at;
};

/// One run of one node.
class Waiting {
 public:
  void sent(std::int64_t sequence, WallTime now) {
    if (sequence > last_) blocks_.push_back({last_ = sequence, now});
  }
  void durable(std::int64_t sequence, WallTime now, std::vector<double>& waited_ms) {
    for (; !blocks_.empty() && blocks_.front().sequence <= sequence; blocks_.pop_front())
      waited_ms.push_back(1e3 * std::chrono::duration<double>(now - blocks_.front().at).count());
  }
  std::size_t blocks() const { return blocks_.size(); }

 private:
  std::int64_t last_ = 0;
  std::deque<Sent> blocks_;  ///< not durable yet
};

}  // namespace

int main(int argc, char** argv) {
  const StopOnSignal signals;
  CLI::App app("How long blocks wait until they are durable, for the benchmark.", "bench-durable");
  std::string url;
  add_bus_url(app, url);
  CLI11_PARSE(app, argc, argv);

  Bus bus(url);
  std::map<std::pair<std::int32_t, std::int64_t>, Waiting> runs;
  std::vector<double> waited_ms;
  SealedBlock block;
  bus.subscribe(
      std::string(kBlockChannels) + ".*", [&](std::string_view, std::span<const std::uint8_t> bytes) {
        if (accept(bytes, block) == Refusal::kNone)
          runs[{block.header.node, block.header.epoch}].sent(block.header.sequence, WallClock::now());
      });
  bus.subscribe("RB_ACK_.*", [&](std::string_view, std::span<const std::uint8_t> bytes) {
    if (const auto ack = decode_ack(bytes))
      runs[{ack->node, ack->epoch}].durable(ack->durable, WallClock::now(), waited_ms);
  });
  while (!signals.token().stop_requested()) bus.handle(50ms);

  std::size_t not_durable = 0;
  for (const auto& [run, waiting] : runs) not_durable += waiting.blocks();
  std::ranges::sort(waited_ms);
  const auto of_all = [&](double share) {
    const auto at = static_cast<std::size_t>(std::ceil(share * static_cast<double>(waited_ms.size())));
    return waited_ms.empty() ? NAN : waited_ms[std::max<std::size_t>(at, 1) - 1];
  };
  const nlohmann::json told{{"blocks", waited_ms.size()},
                            {"not_durable", not_durable},
                            {"median_ms", of_all(0.5)},
                            {"p99_ms", of_all(0.99)},
                            {"most_ms", of_all(1.0)}};
  std::printf("%s\n", told.dump().c_str());
  return 0;
}
