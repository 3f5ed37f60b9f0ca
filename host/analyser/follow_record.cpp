#include "host/analyser/follow_record.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <thread>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/compensation.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/remark.hpp"
#include "common/bus/results.hpp"
#include "common/bus/weight_check.hpp"
#include "common/record/record_reader.hpp"
#include "host/analyser/durable_gate.hpp"
#include "host/analyser/live_orders.hpp"
#include "host/analysis/balance/overall_plan.hpp"
#include "host/analysis/identify/diagnostics.hpp"
#include "host/analysis/identify/drive_estimator.hpp"
#include "host/recording/in_sequence.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::seconds kRepeat{1};
/// The last estimate is sent this often before leaving: results are not acknowledged.
constexpr int kFarewells = 3;

class Follower {
 public:
  Follower(const AnalyserOptions& options, const VehicleConfig& vehicle, In<BalancedDrive> before,
           In<Ack> acks)
      : bus_(options.url),
        reader_(options.record),
        before_name_(options.before.string()),
        before_in_(std::move(before)),
        acks_(std::move(acks)),
        after_{.name = "", .vehicle = vehicle, .balance = {}, .compensation = {}},
        estimator_(vehicle),
        orders_(vehicle) {
    for (const auto& node : vehicle.node) running_[node.id] = true;
  }

  /// True if the newest epoch of every node has its end and the record holds nothing more.
  bool ended() const {
    return caught_up_ && !waiting_ &&
           std::none_of(running_.begin(), running_.end(), [](const auto& node) { return node.second; });
  }

  /// Waits a moment for acknowledgements, then consumes what is durable.
  void step(const std::stop_token& stop) {
    take_acks(kRecordPoll);
    while (!stop.stop_requested() && !(caught_up_ = !take())) publish_news();
    if (WallClock::now() - published_ > kRepeat) publish();
    if (WallClock::now() - orders_published_ > kRepeat) publish_orders();
  }

  void publish() {
    const DriveEstimate& estimate = estimator_.estimate();
    after_.balance = estimate.balance;
    after_.compensation = compensate_all(estimate.balance, estimator_.forces(), after_.vehicle);
    publish_remarks(estimate);
    bus_.publish(kIdentificationChannel, encode(estimate.identification));
    // The plan is sent before the results it follows from: who has the one has the other.
    publish_weight_checks();
    for (std::size_t w = 0; w < kWheels; ++w) {
      bus_.publish(kCompensationChannel, encode(after_.compensation[w]));
      bus_.publish(kBalanceChannel, encode(after_.balance[w]));
    }
    published_ = WallClock::now();
  }

  void publish_orders() {
    for (const OrderReport& report : orders_.reports()) bus_.publish(kOrdersChannel, encode(report));
    orders_published_ = WallClock::now();
  }

 private:
  /// Waits up to `timeout` for one, then takes all that have come.
  void take_acks(std::chrono::milliseconds timeout) {
    for (auto ack = acks_.receive_for(timeout); ack; ack = acks_.receive_for(std::chrono::milliseconds(0)))
      gate_.acknowledge(*ack, WallClock::now());
  }

  void publish_remarks(const DriveEstimate& estimate) {
    std::vector<std::string> sentences = diagnostics(estimate.balance);
    sentences.insert(sentences.end(), estimator_.remarks().begin(), estimator_.remarks().end());
    if (estimate.identification.sections > 0)  // else the refusal names them
      for (std::string& sentence : estimator_.clipped()) sentences.push_back(std::move(sentence));
    if (std::string refusal = estimator_.refusal(); !refusal.empty())
      sentences.insert(sentences.begin(), std::move(refusal));
    if (!before_name_.empty() && !before_ && before_in_.finished())
      sentences.push_back("the recording of the drive before, " + before_name_ +
                          ", cannot be compared with: rb-analyser says why where it was started");
    for (const Remark& remark : remarks_of(estimate.identification.time_ns, sentences))
      bus_.publish(kRemarkChannel, encode(remark));
  }

  void publish_weight_checks() {
    if (before_name_.empty()) return;
    if (!before_) before_ = before_in_.receive_for(std::chrono::seconds(0));
    if (!before_ && before_in_.finished()) return;
    for (const WeightCheck& wheel :
         before_ ? check_weights(*before_, after_) : reading_before(before_name_, after_.balance))
      bus_.publish(kWeightCheckChannel, encode(wheel));
  }

  static bool is_last(const SealedBlock& block) {
    return block.kind == BlockKind::kEnd ||
           (block.kind == BlockKind::kGap && decode_gap(block).cause == GapCause::kNodeCrash);
  }

  /// Takes the next block of the record, if it is durable.
  bool take() {
    if (!waiting_) {
      const auto event = reader_.next();
      if (!event) return false;
      if (accept(*event, *block_) != Refusal::kNone) {
        // A fit counts for the blocks behind it, and the gate stops at the first that is not durable yet.
        if (const auto fit = decode_clock_fit(event->data)) {
          estimator_.consume(*fit);
          orders_.consume(*fit);
        }
        return true;
      }
    }
    waiting_ = !gate_.passes(block_->header, WallClock::now());
    if (waiting_) return false;
    in_sequence_.add(*block_, [this](const SealedBlock& block) {
      estimator_.consume(block);
      orders_.consume(block);
      note_end(block);
    });
    return true;
  }

  /// The newest of a node's epochs counts: the crash of one before is declared behind its begin.
  void note_end(const SealedBlock& block) {
    const auto node = running_.find(block.header.node);
    if (node == running_.end()) return;
    if (seen_.emplace(block.header.node, block.header.epoch).second)
      newest_[block.header.node] = block.header.epoch;
    if (newest_[block.header.node] == block.header.epoch) node->second = !is_last(block);
  }

  void publish_news() {
    if (std::exchange(version_, estimator_.version()) != version_) publish();
    // A long record must not keep acknowledgements waiting.
    if (++taken_ % 256 != 0) return;
    take_acks(std::chrono::milliseconds(0));
    if (WallClock::now() - orders_published_ > kRepeat) publish_orders();
  }

  Bus bus_;  ///< speaks only: who hears the bus hears all blocks, whatever he asks for
  RecordReader reader_;
  const std::string before_name_;
  In<BalancedDrive> before_in_;
  In<Ack> acks_;
  std::optional<BalancedDrive> before_;
  BalancedDrive after_;  ///< this drive so far
  DriveEstimator estimator_;
  LiveOrders orders_;
  DurableGate gate_;
  InSequence in_sequence_;
  std::map<std::int32_t, bool> running_;         ///< by node: its newest epoch has no end yet
  std::map<std::int32_t, std::int64_t> newest_;  ///< epoch of each node
  std::set<std::pair<std::int32_t, std::int64_t>> seen_;
  bool caught_up_ = false;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
  bool waiting_ = false;  ///< `block_` was read and is not durable yet
  std::int64_t version_ = 0;
  std::int64_t taken_ = 0;
  WallTime published_{}, orders_published_{};
};

}  // namespace

void follow_record(std::stop_token stop, const AnalyserOptions& options, const VehicleConfig& vehicle,
                   In<BalancedDrive> before, In<Ack> acks) {
  Follower follower(options, vehicle, std::move(before), std::move(acks));
  while (!stop.stop_requested() && !(follower.ended() && options.exit_at_end && options.may_exit()))
    follower.step(stop);
  for (int i = 0; i < kFarewells && follower.ended(); ++i) {
    if (i > 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    follower.publish();
    follower.publish_orders();
  }
}

}  // namespace roadbalance
