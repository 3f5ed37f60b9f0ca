#include <algorithm>
#include <array>
#include <chrono>
#include <map>

#include "common/bus/bus.hpp"
#include "hil_tests/fuzz/ack_check.hpp"
#include "hil_tests/fuzz/byte_reader.hpp"
#include "hil_tests/fuzz/delivery_check.hpp"
#include "hil_tests/fuzz/in_form.hpp"
#include "hil_tests/fuzz/true_node.hpp"
#include "host/recorder/recorder_link.hpp"

// RecorderLink as a sequence of datagrams: honest nodes, and anything on any channel, with and without a good
// CRC.
namespace roadbalance {
namespace {

constexpr std::array<fuzz::TrueNode, 3> kHonest{{{1, 11, 60}, {1, 12, 1000}, {2, 21, 9}}};

fuzz::Reached answered("a command that is answered");

class Run {
 public:
  explicit Run(std::span<const std::uint8_t> bytes) : in_(bytes) {}

  void play() {
    while (!in_.empty()) {
      step();
      deliver();
    }
    turn();
    link_.farewell([](const std::string&, std::span<const std::uint8_t>) { return true; });
    (void)link_.report();
  }

 private:
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
        return anything();
      case 5:
        return durable();
      case 6:
        return turn();
      default:
        if (const auto what = in_.byte(); what == 0)
          link_.stop(now_);
        else if (what % 4 == 2)
          answer();
        else
          link_.set_credit_open(what & 1);
        (void)link_.over(now_);
    }
  }

  const fuzz::TrueNode& honest() { return kHonest[static_cast<std::size_t>(in_.below(3))]; }

  std::int64_t delivered(const fuzz::TrueNode& node) const {
    return deliveries_.delivered(node.node, node.epoch);
  }

  void honest_block() {
    const auto& node = honest();
    const SealedBlock block = node.some_block(in_, delivered(node));
    link_.take(block_channel(node.node, block.kind), block.bytes(), now_);
  }

  void honest_heartbeat() {
    const auto& node = honest();
    Heartbeat beat = node.some_heartbeat(in_, delivered(node));
    beat.owner = in_.below(3);
    hear(node.node, encode(beat));
  }

  void hear(std::int32_t node, std::span<const std::uint8_t> bytes) {
    if (const auto beat = decode_heartbeat(bytes)) deliveries_.heard(*beat);
    link_.take(heartbeat_channel(node), bytes, now_);
  }

  // Reply of a node that obeys, or gives a reason why it does not.
  void answer() {
    const auto& node = honest();
    const auto asked = asked_.find(node.node);
    if (asked == asked_.end()) return;
    answered.count();
    const Reply reply{.node = node.node,
                      .epoch = node.epoch,
                      .request = asked->second.request,
                      .result = static_cast<CommandError>(in_.below(6)),
                      .sequence = in_.below(64)};
    link_.take(reply_channel(node.node), encode(reply), now_);
  }

  // Messages of the nodes 7 and 8, which send anything.
  void anything() {
    const std::int32_t node = 7 + static_cast<std::int32_t>(in_.below(2));
    const std::uint8_t how = in_.byte();
    const auto bytes = in_.take(static_cast<std::size_t>(in_.below(200)));
    if (how & 1)
      hear(node, fuzz::in_form(encode(Heartbeat{.node = node, .epoch = 1}), bytes));
    else if (how & 2)
      link_.take(reply_channel(node), fuzz::in_form(encode(Reply{.node = node, .epoch = 1}), bytes), now_);
    else if (how & 4)
      link_.take(block_channel(node, BlockKind::kScan), bytes, now_);
    else
      hear(node, bytes);
  }

  void durable() {
    const auto& node = honest();
    const std::int64_t sequence = node.some_durable(in_, delivered(node));
    acks_.durable(node.node, node.epoch, sequence);
    link_.durable({.node = node.node, .epoch = node.epoch, .sequence = sequence}, now_);
  }

  void deliver() {
    for (const Delivery& delivery : link_.deliveries()) deliveries_.take(delivery);
    deliveries_.settled();
  }

  void turn() {
    link_.turn(now_, [this](const std::string& channel, std::span<const std::uint8_t> bytes) {
      if (const auto ack = decode_ack(bytes)) {
        fuzz::require(channel == ack_channel(ack->node), "an ack goes to its node");
        acks_.take(*ack);
      } else {
        const auto command = decode_command(bytes);
        fuzz::require(command && channel == command_channel(command->node), "what is no ack is a command");
        asked_[command->node] = *command;
      }
      return in_.byte() % 16 != 1;  // now and then this computer will not send
    });
  }

  fuzz::ByteReader in_;
  WallTime now_{std::chrono::hours(1)};
  RecorderLink link_{{}, 1, {}};
  fuzz::DeliveryCheck deliveries_;
  fuzz::AckCheck acks_;
  std::map<std::int32_t, Command> asked_;  // of each node, the last one
};

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  roadbalance::Run({data, size}).play();
  return 0;
}
