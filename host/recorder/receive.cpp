#include "host/recorder/receive.hpp"

#include <algorithm>
#include <map>
#include <random>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/link/receiver.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recorder/node_control.hpp"
#include "host/recorder/tally.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kTurn{2};  // longest wait for the bus: bounds the delay of an acknowledgement
constexpr milliseconds kReport{200};
constexpr milliseconds kLastWords{50};  // after the release: answers of the last acks
// At the end the last acks are repeated until each node has heard that all is durable, or is silent.
constexpr milliseconds kNodeSilence{500};
constexpr milliseconds kMostLastAcks{2000};

class Reception {
 public:
  Reception(const RecorderOptions& options, const Recovered& recovered)
      : options_(options),
        bus_(options.url),
        receiver_(next_incarnation(options.folder)),
        control_(receiver_.incarnation(), options.start, std::random_device{}()),
        tally_(recovered) {
    for (const auto& [key, epoch] : recovered.epoch) receiver_.recover(key.first, key.second, epoch.position);
    bus_.subscribe("RB_HEARTBEAT_.*", [this](std::string_view, auto bytes) { on_heartbeat(bytes); });
    bus_.subscribe("RB_BLOCK_.*", [this](std::string_view, auto bytes) { on_block(bytes); });
    bus_.subscribe("RB_REPLY_.*", [this](std::string_view, auto bytes) { on_reply(bytes); });
  }

  /// One turn: what has arrived, what has become durable, what is to be said.
  std::vector<Delivery> turn(In<std::vector<DurableMark>>& durable) {
    delivered_.clear();
    bus_.handle(kTurn);
    while (const auto marks = durable.receive_for(milliseconds(0)))
      for (const auto& mark : *marks) on_durable(mark);
    for (const auto& delivery : delivered_) tally_.take(delivery);
    raise_incarnation_if_needed();
    const WallTime now = WallClock::now();
    for (const auto& ack : receiver_.due(now)) publish(ack_channel(ack.node), encode(ack));
    for (const auto& command : control_.due(now)) send(command);
    return std::exchange(delivered_, {});
  }

  void stop() { control_.stop(); }

  void farewell() {
    for (const auto& command : control_.farewell()) send(command);
    bus_.handle(kLastWords);
  }

  /// Every node that was started has its end on the disk.
  bool all_ended() const {
    return std::all_of(heard_.begin(), heard_.end(), [this](const auto& heard) {
      return !control_.was_started(heard.first) || has_ended(heard.first);
    });
  }

  /// Every node of options.nodes was heard and has its end on the disk.
  bool expected_have_ended() const {
    return std::all_of(options_.nodes.begin(), options_.nodes.end(),
                       [this](std::int32_t node) { return has_ended(node); });
  }

  /// Every node whose end is on the disk says that it has nothing to keep any more, or says nothing.
  bool nodes_have_let_go(WallTime now) const {
    return std::all_of(heard_.begin(), heard_.end(), [&](const auto& heard) {
      const auto& [node, last] = heard;
      return !has_ended(node) || !last.holds_blocks || now - last.at >= kNodeSilence;
    });
  }

  WallTime last_news() const { return last_news_; }

  RecorderReport report() const {
    RecorderReport report = tally_.report();
    report.blocks_refused = refused_;
    for (const std::int64_t count : receiver_.refused()) report.blocks_refused += count;
    report.rival_heartbeats = receiver_.rival_heartbeats();
    report.unsent = unsent_;
    return report;
  }

 private:
  void on_heartbeat(std::span<const std::uint8_t> bytes) {
    const auto heartbeat = decode_heartbeat(bytes);
    if (!heartbeat || !is_ours(heartbeat->node)) return;
    const WallTime now = WallClock::now();
    receiver_.take(*heartbeat, now, delivered_);
    control_.take(*heartbeat);
    const auto* epoch = receiver_.current(heartbeat->node);
    if (!epoch || epoch->epoch() != heartbeat->epoch) return;
    heard_[heartbeat->node] = {.at = now, .holds_blocks = heartbeat->base < heartbeat->next};
    tally_.take(*heartbeat);
  }

  void on_block(std::span<const std::uint8_t> bytes) {
    if (accept(bytes, block_) != Refusal::kNone || !is_ours(block_.header.node)) {
      ++refused_;
      return;
    }
    last_news_ = WallClock::now();
    receiver_.take(block_, last_news_, delivered_);
  }

  void on_reply(std::span<const std::uint8_t> bytes) {
    if (const auto reply = decode_reply(bytes)) control_.take(*reply);
  }

  void on_durable(const DurableMark& mark) {
    last_news_ = WallClock::now();
    receiver_.durable(mark.node, mark.epoch, mark.sequence);
  }

  bool is_ours(std::int32_t node) const {
    return options_.nodes.empty() ||
           std::find(options_.nodes.begin(), options_.nodes.end(), node) != options_.nodes.end();
  }

  bool has_ended(std::int32_t node) const {
    const auto* epoch = receiver_.current(node);
    return epoch && epoch->ended() && epoch->durable() == epoch->received();
  }

  void raise_incarnation_if_needed() {
    if (control_.obeyed_higher() == 0) return;
    const std::int64_t number = raise_incarnation(options_.folder, control_.obeyed_higher());
    receiver_.set_incarnation(number);
    control_.set_incarnation(number);
  }

  void send(const Command& command) { publish(command_channel(command.node), encode(command)); }

  void publish(const std::string& channel, std::span<const std::uint8_t> bytes) {
    if (!bus_.publish(channel, bytes)) ++unsent_;
  }

  struct Heard {
    WallTime at{};
    bool holds_blocks = false;
  };

  const RecorderOptions& options_;
  Bus bus_;
  Receiver receiver_;
  NodeControl control_;
  Tally tally_;
  std::map<std::int32_t, Heard> heard_;  // the last heartbeat of the epoch being received
  std::vector<Delivery> delivered_;
  SealedBlock block_;
  std::int64_t refused_ = 0;
  std::int64_t unsent_ = 0;
  WallTime last_news_ = WallClock::now();
};

}  // namespace

void receive(std::stop_token stop, const RecorderOptions& options, const Recovered& recovered,
             Out<std::vector<Delivery>> deliveries, In<std::vector<DurableMark>> durable,
             RecorderReport& report) {
  Reception reception(options, recovered);
  WallTime reported_at{};
  WallTime stopped_at{};
  WallTime working_at{};
  bool stopping = false;
  for (bool over = false; !over;) {
    // Asked first: a writer that fails closes `durable` and only then stops everybody here.  The nodes are
    // not meant: they go on, keep what is not durable and wait for the next recorder.
    const bool told_to_stop = stop.stop_requested();
    auto delivered = reception.turn(durable);
    if (durable.finished()) break;
    if (!delivered.empty() && !deliveries.send(std::move(delivered))) break;
    const WallTime now = WallClock::now();
    if (told_to_stop && !stopping) {
      stopping = true;
      stopped_at = now;
      reception.stop();
    }
    const bool silent = now - std::max(reception.last_news(), stopped_at) >= options.patience;
    const bool done = (stopping && (reception.all_ended() || silent)) ||
                      (options.end_with_nodes && reception.expected_have_ended());
    if (!done) working_at = now;
    over = done && (reception.nodes_have_let_go(now) || now - working_at >= kMostLastAcks);
    if (options.on_progress && (over || now - reported_at >= kReport)) {
      options.on_progress(reception.report());
      reported_at = now;
    }
  }
  reception.farewell();
  report = reception.report();
}

}  // namespace roadbalance
