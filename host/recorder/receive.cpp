#include "host/recorder/receive.hpp"

#include <algorithm>
#include <random>
#include <set>

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

class Reception {
 public:
  Reception(const RecorderOptions& options, const Recovered& recovered)
      : options_(options),
        bus_(options.url),
        receiver_(next_incarnation(options.folder)),
        control_(receiver_.incarnation(), options.nodes, options.start, std::random_device{}()),
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
    for (const auto& ack : receiver_.due(now)) bus_.publish(ack_channel(ack.node), encode(ack));
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
    return std::all_of(nodes_.begin(), nodes_.end(),
                       [this](std::int32_t node) { return !control_.was_started(node) || has_ended(node); });
  }

  /// Every node of options.nodes was heard and has its end on the disk.
  bool expected_have_ended() const {
    return std::all_of(options_.nodes.begin(), options_.nodes.end(),
                       [this](std::int32_t node) { return has_ended(node); });
  }

  WallTime last_news() const { return last_news_; }

  RecorderReport report() const {
    RecorderReport report = tally_.report();
    report.blocks_refused = refused_;
    for (const std::int64_t count : receiver_.refused()) report.blocks_refused += count;
    return report;
  }

 private:
  void on_heartbeat(std::span<const std::uint8_t> bytes) {
    const auto heartbeat = decode_heartbeat(bytes);
    if (!heartbeat || !is_ours(heartbeat->node)) return;
    const WallTime now = WallClock::now();
    nodes_.insert(heartbeat->node);
    receiver_.take(*heartbeat, now, delivered_);
    control_.take(*heartbeat, now);
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
    tally_.take_durable(mark.node, mark.epoch, mark.sequence);
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

  void send(const Command& command) { bus_.publish(command_channel(command.node), encode(command)); }

  const RecorderOptions& options_;
  Bus bus_;
  Receiver receiver_;
  NodeControl control_;
  Tally tally_;
  std::set<std::int32_t> nodes_;
  std::vector<Delivery> delivered_;
  SealedBlock block_;
  std::int64_t refused_ = 0;
  WallTime last_news_ = WallClock::now();
};

}  // namespace

void receive(std::stop_token stop, const RecorderOptions& options, const Recovered& recovered,
             Out<std::vector<Delivery>> deliveries, In<std::vector<DurableMark>> durable,
             RecorderReport& report) {
  Reception reception(options, recovered);
  if (options.on_ready) options.on_ready();
  WallTime reported_at{};
  WallTime stopped_at{};
  bool stopping = false;
  for (bool over = false; !over;) {
    auto delivered = reception.turn(durable);
    if (!delivered.empty() && !deliveries.send(std::move(delivered))) break;  // the writer is gone
    const WallTime now = WallClock::now();
    if (stop.stop_requested() && !stopping) {
      stopping = true;
      stopped_at = now;
      reception.stop();
    }
    const bool silent = now - std::max(reception.last_news(), stopped_at) >= options.patience;
    over = (stopping && (reception.all_ended() || silent)) ||
           (options.end_with_nodes && reception.expected_have_ended());
    if (options.on_progress && (over || now - reported_at >= kReport)) {
      options.on_progress(reception.report());
      reported_at = now;
    }
  }
  reception.farewell();
  report = reception.report();
}

}  // namespace roadbalance
