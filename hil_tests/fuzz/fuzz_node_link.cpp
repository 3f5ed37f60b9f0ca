#include <chrono>
#include <map>

#include "common/bus/bus.hpp"
#include "common/types/text_crc.hpp"
#include "firmware/node_link.hpp"
#include "hil_tests/fuzz/byte_reader.hpp"
#include "hil_tests/fuzz/in_form.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "hil_tests/fuzz/true_node.hpp"

// NodeLink, Sender, Commands and Backlog as a sequence of messages: a producer, and a bus on which recorders,
// stale recorders and strangers send anything.
namespace roadbalance {
namespace {

using fuzz::require;

fuzz::Reached started("a node that records"), blocks_sent("a block that is sent"),
    freed("a block that is durable");
constexpr fuzz::TrueNode kNode{3, 77, std::int64_t{1} << 40};
constexpr std::size_t kRingBlocks = 32;

class Run {
 public:
  explicit Run(std::span<const std::uint8_t> bytes) : in_(bytes) {}

  void play() {
    while (!in_.empty()) {
      step();
      check();
    }
    turn();
  }

 private:
  void step() {
    switch (in_.byte() % 8) {
      case 0:
        now_ += std::chrono::milliseconds(in_.below(256));
        return;
      case 1:
        now_ += std::chrono::milliseconds(2000);
        return;
      case 2:
        return produce(in_.below(16));
      case 3:
        return ack();
      case 4:
        return command();
      case 5:
        return any_ack();
      case 6:
        return link_.take(in_.below(2) ? command_channel(kNode.node) : vehicle_channel(kNode.node),
                          in_.take(static_cast<std::size_t>(in_.below(64))), now_);
      default:
        return turn();
    }
  }

  // As the sampling process does it.
  void produce(std::int64_t count) {
    if (acquire_.start_at.load() != AcquireLink::kNotAsked && acquire_.state == NodeState::kPreview)
      acquire_.state = NodeState::kStarted;
    if (acquire_.state == NodeState::kStarted) started.count();
    if (acquire_.stop_at.load() != AcquireLink::kNotAsked && in_.below(2) == 1)
      acquire_.state = NodeState::kEnded;
    if (acquire_.state == NodeState::kEnded) count = 0;
    for (; count > 0; --count) {
      SealedBlock* room = ring_.claim();
      if (!room) return require(ring_.used() > 0, "a full ring holds blocks");
      *room = kNode.block(ring_.next());
      ring_.commit();
    }
  }

  // As a recorder would send it, of any age, with a durable mark anywhere up to one past the end.
  void ack() {
    Ack ack{.node = kNode.node, .epoch = kNode.epoch + (in_.byte() % 8 == 0 ? 1 : 0)};
    ack.incarnation = 1 + in_.below(3);
    ack.number = 1 + in_.below(65536);
    ack.durable = std::max<std::int64_t>(0, ring_.next() - in_.below(40));
    ack.received = ack.durable + in_.below(40);
    ack.credit = ack.received + in_.below(40);
    for (std::int64_t first = ack.received + 1 + in_.below(4), k = in_.below(4); k > 0; --k) {
      ack.missing.push_back({first, first + in_.below(4)});
      first = ack.missing.back().last + 2;
    }
    note(ack);
    link_.take(ack_channel(kNode.node), encode(ack), now_);
  }

  // Anything that the decoder lets through.
  void any_ack() {
    const auto bytes = fuzz::in_form(encode(Ack{}), in_.take(static_cast<std::size_t>(in_.below(600))));
    if (const auto ack = decode_ack(bytes)) note(*ack);
    link_.take(ack_channel(kNode.node), bytes, now_);
  }

  // Only the recorder that the node obeys frees anything.
  void note(const Ack& ack) {
    if (link_.owner() == 0 || ack.incarnation != link_.owner()) return;
    if (ack.epoch == kNode.epoch && ack.durable < ring_.next()) durable_ = std::max(durable_, ack.durable);
  }

  void command() {
    const Command command{.node = kNode.node,
                          .request = in_.below(40),
                          .incarnation = 1 + in_.below(3),
                          .verb = static_cast<Verb>(in_.below(7)),
                          .epoch = in_.below(2) * kNode.epoch,
                          .delay_us = in_.below(400'000) - 200'000,
                          .vehicle_crc32c = in_.below(4) > 0 ? crc32c(kWanted) : 0};
    if (command.verb == Verb::kConfigure) vehicle_part();
    link_.take(command_channel(kNode.node), encode(command), now_);
    // Its node would end this epoch and begin the next; here the change is refused, and it goes on.
    if (vehicle_.wanted()) {
      require(acquire_.state == NodeState::kPreview, "no set-up changes while anything is kept");
      require(*vehicle_.wanted() == kWanted, "only what its CRC says is put in force");
      vehicle_.refused("as the fuzzer wishes");
    }
  }

  // One of two; some with bytes that contradict the CRC of the whole.
  void vehicle_part() {
    const auto part = static_cast<std::int32_t>(in_.below(2));
    std::string text = part == 0 ? kWanted.substr(0, 4) : kWanted.substr(4);
    if (in_.below(8) == 0) text[0] = static_cast<char>(in_.byte());
    link_.take(vehicle_channel(kNode.node),
               encode(VehiclePart{.node = kNode.node,
                                  .incarnation = 1,
                                  .vehicle_crc32c = crc32c(kWanted),
                                  .part = part,
                                  .parts = 2,
                                  .text = text}),
               now_);
  }

  void turn() {
    std::size_t datagrams = 0;
    link_.turn(now_, [&](const std::string& channel, std::span<const std::uint8_t> bytes) {
      require(++datagrams < 1000, "a turn sends few datagrams");
      published(channel, bytes);
      return true;
    });
  }

  void published(const std::string& channel, std::span<const std::uint8_t> bytes) {
    SealedBlock block;
    if (channel == heartbeat_channel(kNode.node)) {
      const auto beat = decode_heartbeat(bytes);
      require(beat && beat->base == backlog_.base() && beat->next == ring_.next(),
              "a heartbeat says what is held");
    } else if (channel == reply_channel(kNode.node)) {
      require(decode_reply(bytes).has_value(), "a recorder accepts every reply");
    } else {
      require(accept(bytes, block) == Refusal::kNone, "what else is sent is a block");
      const SealedBlock sealed = kNode.block(block.header.sequence);
      require(std::equal(bytes.begin(), bytes.end(), sealed.bytes().begin(), sealed.bytes().end()),
              "a block goes out as it was sealed");
      const auto sent = sent_at_.find(block.header.sequence);
      require(sent == sent_at_.end() || now_ - sent->second >= std::chrono::milliseconds(10),
              "a block is not sent twice within 10 ms");
      sent_at_[block.header.sequence] = now_;
      blocks_sent.count();
    }
  }

  void check() {
    require(backlog_.base() >= base_ && backlog_.base() <= backlog_.next(), "the base only rises");
    if (backlog_.base() > base_) freed.count();
    base_ = backlog_.base();
    require(base_ <= durable_ + 1, "nothing is freed that no ack called durable");
  }

  const std::string kWanted = "name = \"another\"\n";
  fuzz::ByteReader in_;
  WallTime now_{std::chrono::hours(1)};
  Ring ring_{kRingBlocks * sizeof(SealedBlock)};
  Backlog backlog_{ring_};
  PreviewSlot preview_;
  AcquireLink acquire_;
  VehicleChange vehicle_{"", true};
  NodeLink link_{kNode.node, kNode.epoch, backlog_, preview_, acquire_, vehicle_};
  std::map<std::int64_t, WallTime> sent_at_;
  std::int64_t base_ = 1;
  std::int64_t durable_ = 0;
};

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  roadbalance::Run({data, size}).play();
  return 0;
}
