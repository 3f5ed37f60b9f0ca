#include "common/link/test/link_simulation.hpp"

#include <algorithm>
#include <utility>

namespace roadbalance::test {
namespace {
constexpr double kBlockPeriod_ms = 4;
constexpr std::int32_t kNode = 1;

// Behind a crash gap, or in a gap of blocks gone, which covers all numbers since the delivery before it.
bool is_declared(const std::map<std::int64_t, Delivery>& recorded, std::int64_t sequence) {
  const auto next = recorded.lower_bound(sequence);
  if (next == recorded.end()) return true;
  const auto* gap = std::get_if<GapBlock>(&next->second);
  return gap && (gap->cause == GapCause::kLostAtNode || gap->header.sequence == sequence);
}
}  // namespace

void LinkSimulation::after_ms(double ms, Action action) {
  events_.push({time_us_ + static_cast<std::int64_t>(1000 * ms), order_++, std::move(action)});
}

void LinkSimulation::fault(const std::string& what) {
  outcome_.faults.push_back(std::to_string(time_us_) + " us: " + what);
}

// Each datagram is lost, doubled or late on its own.
void LinkSimulation::network(Action arrive) {
  const double seconds = static_cast<double>(time_us_) * 1e-6;
  if (scenario_.cable_out_s <= seconds && seconds < scenario_.cable_in_s) return;
  const int copies = uniform(0, 1) < scenario_.duplicates ? 2 : 1;
  for (int copy = 0; copy < copies; ++copy) {
    if (uniform(0, 1) < scenario_.loss) continue;
    const double late_ms = uniform(0, 1) < scenario_.reordered ? uniform(5, 50) : 0;
    after_ms(uniform(0.1, 2) + late_ms, arrive);
  }
}

void LinkSimulation::boot_node() {
  node_.emplace(++epochs_, scenario_.ring_bytes);
}

void LinkSimulation::produce() {
  if (!producing_) return;
  after_ms(kBlockPeriod_ms, [this] { produce(); });
  if (!node_) return;
  SealedBlock* slot = node_->ring.claim();
  if (!slot) return;  // a device that waits
  ScanBlock block;
  const std::int64_t sequence = node_->ring.next();
  block.header = {.node = kNode,
                  .epoch = node_->epoch,
                  .sequence = sequence,
                  .first_scan = (sequence - 1) * kScansPerBlock,
                  .scans = kScansPerBlock,
                  .time_ns = time_us_ * 1000};
  block.period_ps = 200'000'000;
  for (auto& row : block.counts)
    for (auto& count : row) count = static_cast<std::int32_t>(random_());
  seal(block, *slot);
  node_->ring.commit();
  truth_[node_->epoch][sequence] = {*slot, time_us_};
  ++outcome_.sealed;
}

void LinkSimulation::pump() {
  after_ms(1, [this] { pump(); });
  if (!node_) return;
  for (const std::int64_t sequence : node_->sender.due(now()))
    network([this, block = node_->ring.get(sequence)] {
      take_up([&](auto& out) { receiver_->take(block, now(), out); });
    });
}

void LinkSimulation::beat() {
  after_ms(100, [this] { beat(); });
  if (!node_) return;
  const Heartbeat heartbeat{.node = kNode,
                            .epoch = node_->epoch,
                            .base = node_->ring.base(),
                            .next = node_->ring.next(),
                            .state = NodeState::kStarted,
                            .owner = node_->sender.owner()};
  network([this, heartbeat] { take_up([&](auto& out) { receiver_->take(heartbeat, now(), out); }); });
}

void LinkSimulation::take_up(const std::function<void(std::vector<Delivery>&)>& input) {
  if (receiver_) input(written_);
}

void LinkSimulation::claim() {
  after_ms(100, [this] { claim(); });
  if (!receiver_) return;
  network([this, incarnation = incarnation_] {
    if (node_) node_->sender.claim(incarnation, now());
  });
}

void LinkSimulation::acknowledge() {
  after_ms(5, [this] { acknowledge(); });
  if (!receiver_) return;
  for (const Ack& ack : receiver_->due(now()))
    network([this, ack] {
      if (!node_) return;
      node_->sender.take(ack, now());
      check_freed();
    });
}

void LinkSimulation::sync() {
  after_ms(200, [this] { sync(); });
  if (!receiver_ || syncing_ || written_.empty()) return;
  syncing_ = true;
  const double slow_ms = uniform(0, 1) < scenario_.slow_syncs ? uniform(500, 3000) : 0;
  after_ms(uniform(1, 30) + slow_ms, [this, batch = std::exchange(written_, {}), incarnation = incarnation_] {
    if (!receiver_ || incarnation != incarnation_) return;  // killed meanwhile: nothing was promised
    syncing_ = false;
    for (const auto& delivery : batch) store(delivery);
  });
}

void LinkSimulation::store(const Delivery& delivery) {
  const BlockHeader header = std::visit([](const auto& block) { return block.header; }, delivery);
  auto& epoch = disk_.epoch[header.epoch];
  if (!epoch.empty() && header.sequence <= epoch.rbegin()->first)
    fault("block " + std::to_string(header.sequence) + " recorded twice or out of order");
  epoch.emplace(header.sequence, delivery);
  receiver_->durable(header.node, header.epoch, header.sequence);
  const auto& sealed = truth_[header.epoch];
  if (const auto found = sealed.find(header.sequence); found != sealed.end())
    outcome_.longest_to_durable_s =
        std::max(outcome_.longest_to_durable_s, static_cast<double>(time_us_ - found->second.second) * 1e-6);
}

void LinkSimulation::check_freed() {
  const std::int64_t freed = node_->ring.base() - 1;
  const auto& epoch = disk_.epoch[node_->epoch];
  if (freed > 0 && !epoch.contains(freed)) fault("freed block " + std::to_string(freed) + " is not durable");
}

void LinkSimulation::boot_recorder() {
  ++incarnation_;
  receiver_.emplace(incarnation_);
  for (const auto& [number, blocks] : disk_.epoch) {
    if (blocks.empty()) continue;
    const auto* last = std::get_if<SealedBlock>(&blocks.rbegin()->second);
    const std::int64_t next_scan = last ? last->header.first_scan + last->header.scans : 0;
    receiver_->recover(kNode, number, {blocks.rbegin()->first, next_scan, last == nullptr});
  }
}

void LinkSimulation::kill_recorder() {
  if (!receiver_) return;
  receiver_.reset();
  written_.clear();
  syncing_ = false;
  after_ms(uniform(200, 2000), [this] { boot_recorder(); });
}

void LinkSimulation::kill_node() {
  if (!node_) return;
  transmissions_before_ += node_->sender.blocks_sent();
  node_.reset();
  after_ms(uniform(500, 3000), [this] { boot_node(); });
}

// Every block sealed is on the disk as it was sealed, or was in the memory of a node that died, behind the
// last recorded block of its epoch and inside that epoch's crash gap.
void LinkSimulation::check_record(LinkOutcome& outcome) {
  for (const auto& [number, sealed] : truth_) {
    const auto& recorded = disk_.epoch[number];
    const auto* crash = recorded.empty() ? nullptr : std::get_if<GapBlock>(&recorded.rbegin()->second);
    for (const auto& [sequence, block] : sealed) {
      const auto found = recorded.find(sequence);
      const auto* kept = found == recorded.end() ? nullptr : std::get_if<SealedBlock>(&found->second);
      if (kept && std::ranges::equal(kept->bytes(), block.first.bytes()))
        ++outcome.recorded;
      else if (crash && crash->cause == GapCause::kNodeCrash && is_declared(recorded, sequence))
        ++outcome.declared;
      else if (!kept && number != epochs_ && recorded.empty())
        ++outcome.declared;  // it died before the recorder ever heard of it
      else
        fault("epoch " + std::to_string(number) + " block " + std::to_string(sequence) +
              " is lost or altered");
    }
  }
}

LinkOutcome LinkSimulation::run() {
  boot_node();
  boot_recorder();
  produce(), pump(), beat(), claim(), acknowledge(), sync();
  const double end_ms = 1000 * scenario_.seconds;
  for (int k = 0; k < scenario_.recorder_kills; ++k)
    after_ms(uniform(0, 0.8 * end_ms), [this] { kill_recorder(); });
  for (int k = 0; k < scenario_.node_kills; ++k) after_ms(uniform(0, 0.8 * end_ms), [this] { kill_node(); });
  after_ms(end_ms, [this] { producing_ = false; });

  const auto end_us = static_cast<std::int64_t>(1000 * end_ms);
  constexpr std::int64_t kLongestDrain_us = 30'000'000;
  bool drained = false;
  while (!drained && time_us_ < end_us + kLongestDrain_us) {
    Event event = events_.top();
    events_.pop();
    time_us_ = event.time_us;
    event.action();
    drained = !producing_ && node_ && receiver_ && node_->ring.used() == 0 && written_.empty() && !syncing_;
  }
  if (!drained) fault("the backlog does not go to zero");
  receiver_->finish(now(), written_);
  for (const auto& delivery : written_) store(delivery);
  outcome_.drained_after_s = static_cast<double>(time_us_ - end_us) * 1e-6;
  outcome_.transmissions = transmissions_before_ + (node_ ? node_->sender.blocks_sent() : 0);
  check_record(outcome_);
  return outcome_;
}

}  // namespace roadbalance::test
