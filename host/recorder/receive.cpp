#include "host/recorder/receive.hpp"

#include <random>

#include "common/bus/bus.hpp"
#include "host/recorder/incarnation.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kTurn{2};  // longest wait for the bus: bounds the delay of an acknowledgement
constexpr milliseconds kReport{200};
constexpr milliseconds kLastWords{50};  // after the release: answers of the last acks

RecorderLinkOptions link_options(const RecorderOptions& options) {
  return {.start = options.start,
          .nodes = options.nodes,
          .end_with_nodes = options.end_with_nodes,
          .patience = options.patience,
          .seed = std::random_device{}()};
}

std::int64_t utc_ms() {
  using namespace std::chrono;
  return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

// The link on its bus.
class Reception {
 public:
  Reception(const RecorderOptions& options, const Recovered& recovered)
      : options_(options),
        bus_(options.url),
        link_(link_options(options), next_incarnation(options.folder, utc_ms()), recovered) {
    for (const char* channels : {"RB_HEARTBEAT_.*", "RB_BLOCK_.*", "RB_REPLY_.*"})
      bus_.subscribe(channels, [this](std::string_view channel, auto bytes) {
        link_.take(channel, bytes, WallClock::now());
      });
  }

  RecorderLink& link() { return link_; }

  /// One turn: what has arrived, what has become durable, what is to be said.
  std::vector<Delivery> turn(In<std::vector<DurableMark>>& durable) {
    bus_.handle(kTurn);
    const WallTime now = WallClock::now();
    while (const auto marks = durable.receive_for(milliseconds(0)))
      for (const auto& mark : *marks) link_.durable(mark, now);
    if (link_.obeyed_higher() > 0)
      link_.set_incarnation(raise_incarnation(options_.folder, link_.obeyed_higher()));
    link_.turn(now, publish_);
    return link_.deliveries();
  }

  void farewell() {
    link_.farewell(publish_);
    bus_.handle(kLastWords);
  }

 private:
  const RecorderOptions& options_;
  Bus bus_;
  RecorderLink link_;
  const Publish publish_ = [this](const std::string& channel, std::span<const std::uint8_t> bytes) {
    return bus_.publish(channel, bytes);
  };
};

}  // namespace

void receive(std::stop_token stop, const RecorderOptions& options, const Recovered& recovered,
             Out<std::vector<Delivery>> deliveries, In<std::vector<DurableMark>> durable,
             RecorderReport& report) {
  Reception reception(options, recovered);
  RecorderLink& link = reception.link();
  WallTime reported_at{};
  for (bool over = false; !over;) {
    // Asked first: a writer that fails closes `durable` and only then stops everybody here.  The nodes are
    // not meant: they go on, keep what is not durable and wait for the next recorder.
    const bool told_to_stop = stop.stop_requested();
    auto delivered = reception.turn(durable);
    if (durable.finished()) break;
    if (!delivered.empty() && !deliveries.send(std::move(delivered))) break;
    const WallTime now = WallClock::now();
    if (told_to_stop) link.stop(now);
    over = link.over(now);
    if (options.on_progress && (over || now - reported_at >= kReport)) {
      options.on_progress(link.report());
      reported_at = now;
    }
  }
  reception.farewell();
  report = link.report();
}

}  // namespace roadbalance
