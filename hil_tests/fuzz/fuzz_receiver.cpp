#include <array>
#include <chrono>

#include "common/link/receiver.hpp"
#include "hil_tests/fuzz/ack_check.hpp"
#include "hil_tests/fuzz/byte_reader.hpp"
#include "hil_tests/fuzz/delivery_check.hpp"
#include "hil_tests/fuzz/true_node.hpp"

// Receiver and EpochReceiver as a sequence of messages.  Honest nodes behind a network that loses, doubles,
// delays and mixes; strangers that send anything a decoder lets through; a disk that calls any block
// durable.
namespace roadbalance {
namespace {

constexpr ReceiverOptions kSmall{.window = 32, .undurable = 64};
constexpr std::array<fuzz::TrueNode, 4> kHonest{{{1, 11, 60}, {1, 12, 1000}, {2, 21, 9}, {3, -31, 1 << 20}}};
constexpr std::int32_t kStranger = 7;

class Run {
 public:
  explicit Run(std::span<const std::uint8_t> bytes) : in_(bytes) {}

  void play() {
    if (in_.byte() & 1) recover();
    while (!in_.empty()) {
      step();
      take_all();
      fuzz::require(out_.size() <= 4 * static_cast<std::size_t>(kSmall.window),
                    "one message delivers no more than the windows hold");
      out_.clear();
    }
    now_ += std::chrono::seconds(1);
    receiver_.finish(now_, out_);
    take_all();
    for (const Ack& ack : receiver_.due(now_)) acks_.take(ack);
  }

 private:
  void take_all() {
    for (const Delivery& delivery : out_) deliveries_.take(delivery);
    deliveries_.settled();
  }

  void recover() {
    const auto& node = kHonest[0];
    const std::int64_t through = in_.below(node.last);
    receiver_.recover(node.node, node.epoch,
                      {.contiguous = through, .next_scan = node.first_scan(through + 1)});
    deliveries_.recovered(node.node, node.epoch, through);
    acks_.durable(node.node, node.epoch, through);
  }

  void step() {
    switch (in_.byte() % 8) {
      case 0:
        now_ += std::chrono::milliseconds(in_.below(256));
        return;
      case 1:
        now_ += std::chrono::seconds(in_.below(20));
        return;
      case 2:
        return honest_block();
      case 3:
        return honest_heartbeat();
      case 4:
        return strange_block();
      case 5:
        return strange_heartbeat();
      case 6:
        return durable();
      default:
        if (in_.byte() % 4 == 0) receiver_.set_credit_open(in_.byte() & 1);
        for (const Ack& ack : receiver_.due(now_)) acks_.take(ack);
    }
  }

  const fuzz::TrueNode& honest() { return kHonest[static_cast<std::size_t>(in_.below(4))]; }

  std::int64_t delivered(const fuzz::TrueNode& node) const {
    return deliveries_.delivered(node.node, node.epoch);
  }

  void honest_block() {
    const auto& node = honest();
    receiver_.take(node.some_block(in_, delivered(node)), now_, out_);
  }

  void honest_heartbeat() {
    const auto& node = honest();
    hear(node.some_heartbeat(in_, delivered(node)));
  }

  std::int64_t index() {
    const std::uint64_t value = in_.number(in_.byte() % 8 + 1);
    return static_cast<std::int64_t>(value % (static_cast<std::uint64_t>(kIndexLimit) + 1));
  }

  void strange_block() {
    SealedBlock block;
    block.kind = static_cast<BlockKind>(in_.below(kBlockKinds));
    block.header = {.node = kStranger + static_cast<std::int32_t>(in_.below(3)),
                    .epoch = in_.below(20),
                    .sequence = index(),
                    .first_scan = index()};
    block.header.scans = std::min(index(), kIndexLimit - block.header.first_scan);
    // Up to the limits of a clock, too.
    block.header.time_ns =
        index() * (in_.byte() & 1 ? 1 : -1) * (in_.byte() & 1 ? 1 : kClockLimit_ns / kIndexLimit);
    receiver_.take(block, now_, out_);
  }

  void strange_heartbeat() {
    Heartbeat beat{.node = kStranger + static_cast<std::int32_t>(in_.below(200)), .epoch = in_.below(20)};
    beat.next = std::max<std::int64_t>(1, index());
    beat.base = std::clamp<std::int64_t>(index(), 1, beat.next);
    beat.state = static_cast<NodeState>(in_.below(4));
    hear(beat);
  }

  void hear(const Heartbeat& beat) {
    deliveries_.heard(beat);
    receiver_.take(beat, now_, out_);
  }

  void durable() {
    const auto& node = honest();
    const std::int64_t sequence = node.some_durable(in_, delivered(node));
    acks_.durable(node.node, node.epoch, sequence);
    receiver_.durable(node.node, node.epoch, sequence);
  }

  fuzz::ByteReader in_;
  WallTime now_{std::chrono::hours(1)};
  Receiver receiver_{1, kSmall};
  std::vector<Delivery> out_;
  fuzz::DeliveryCheck deliveries_;
  fuzz::AckCheck acks_;
};

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  roadbalance::Run({data, size}).play();
  return 0;
}
