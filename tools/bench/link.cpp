#include <lcm/lcm.h>

#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/process_port.hpp"
#include "common/link/receiver.hpp"
#include "common/link/sender.hpp"
#include "tools/bench/bare.hpp"
#include "tools/bench/bench_blocks.hpp"
#include "tools/bench/contest.hpp"

// The loss-free link from a sealed block to one that the recorder may write, beside the same datagrams over
// bare UDP and over LCM with nothing of ours: lines of JSON as bench-peers.  Both ends are in this program
// and take turns.

namespace roadbalance::bench {
namespace {

using namespace std::chrono_literals;
constexpr int kBlocks = 512;  // a call
constexpr std::int64_t kEpoch = 9, kOwner = 1;

/// Node and recorder, each with its own place on the bus.
class Link {
 public:
  Link() {
    recorder_.subscribe("RB_BLOCK_.*", [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (accept(bytes, taken_) == Refusal::kNone) receiver_.take(taken_, now_, delivered_);
    });
    node_.subscribe("RB_ACK_.*", [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto ack = decode_ack(bytes)) acked_ += sender_.take(*ack, now_);
    });
    sender_.claim(kOwner, now_);
    beat();
    acknowledge();
  }

  void burst(int blocks) {
    for (int k = 0; k < blocks; ++k) {
      block_.header = {.node = 1,
                       .epoch = kEpoch,
                       .sequence = ring_.next(),
                       .first_scan = kScansPerBlock * (ring_.next() - 1),
                       .scans = kScansPerBlock,
                       .time_ns = 10'000'000 * (ring_.next() - 1)};
      seal(block_, *ring_.claim());
      ring_.commit();
    }
    now_ += 20ms;
    beat();
    node_.gather(channel_);
    for (const std::int64_t sequence : sender_.due(now_))
      if (const SealedBlock* block = backlog_.get(sequence)) node_.publish(channel_, block->bytes());
    if (node_.send_gathered() != 0) throw std::runtime_error("a block was not sent");
    while (delivered_.size() < static_cast<std::size_t>(blocks))
      if (recorder_.handle(1s) == 0) throw std::runtime_error("a block was lost on loopback");
    receiver_.durable(1, kEpoch, ring_.next() - 1);
    delivered_.clear();
    acknowledge();
    if (ring_.base() != ring_.next()) throw std::runtime_error("the node still holds blocks");
  }

 private:
  void beat() {
    receiver_.take(Heartbeat{.node = 1,
                             .epoch = kEpoch,
                             .base = ring_.base(),
                             .next = ring_.next(),
                             .state = NodeState::kStarted},
                   now_, delivered_);
  }
  void acknowledge() {
    const auto before = acked_;
    for (const Ack& ack : receiver_.due(now_)) recorder_.publish(ack_channel(1), encode(ack));
    while (acked_ == before)
      if (node_.handle(1s) == 0) throw std::runtime_error("an acknowledgement was lost on loopback");
  }

  const std::string url_ = bus_url_on_port(process_port()), channel_ = block_channel(1, BlockKind::kScan);
  Bus node_{url_}, recorder_{url_, {.hears_all = true}};
  WallTime now_{std::chrono::hours(1)};
  Ring ring_{16 << 20};
  Backlog backlog_{ring_};
  Sender sender_{backlog_, 1, kEpoch};
  Receiver receiver_{kOwner};
  ScanBlock block_ = scans();
  SealedBlock taken_;
  std::vector<Delivery> delivered_;
  int acked_ = 0;
};

/// The same messages by LCM alone, its own receiver, without a limit to what waits in it.
class BareLcm {
 public:
  explicit BareLcm(std::size_t bytes) : message_(bytes) {
    if (!in_ || !out_) throw std::runtime_error("no LCM");
    auto* const all = lcm_subscribe(
        in_.get(), "BLOCK",
        [](const lcm_recv_buf_t*, const char*, void* seen) { ++*static_cast<int*>(seen); }, &seen_);
    if (!all) throw std::runtime_error("LCM does not subscribe");
    lcm_subscription_set_queue_capacity(all, 0);
  }
  void burst(int blocks) {
    for (int k = 0; k < blocks; ++k)
      lcm_publish(out_.get(), "BLOCK", message_.data(), static_cast<unsigned>(message_.size()));
    for (seen_ = 0; seen_ < blocks;)
      if (lcm_handle_timeout(in_.get(), 1000) <= 0) throw std::runtime_error("a bare message did not come");
  }

 private:
  using Lcm = std::unique_ptr<lcm_t, decltype(&lcm_destroy)>;
  const std::string url_ =
      bus_url_on_port(process_port(2)) + "&recv_buf_size=" + std::to_string(kReceiveBufferBytes);
  Lcm out_{lcm_create(url_.c_str()), &lcm_destroy}, in_{lcm_create(url_.c_str()), &lcm_destroy};
  std::vector<std::uint8_t> message_;
  int seen_ = 0;
};

void run() {
  SealedBlock sealed;
  ScanBlock block = scans();
  block.header = {
      .node = 1, .epoch = 1, .sequence = 1, .first_scan = 0, .scans = kScansPerBlock, .time_ns = 0};
  seal(block, sealed);
  // LCM's datagram: magic, number and name of the channel before it.
  BareUdp bare(sealed.bytes().size() + 8 + block_channel(1, BlockKind::kScan).size() + 1);
  BareLcm lcm(sealed.bytes().size());
  Link link;
  const auto work = [](auto& of, int blocks) {
    return Contender{.work = [&of, blocks] {
      for (int done = 0; done < kBlocks; done += blocks) of.burst(blocks);
    }};
  };
  std::vector<Contender> run{work(link, kMostBurst), work(bare, kMostBurst), work(lcm, kMostBurst),
                             work(link, 1), work(bare, 1)};
  compete(run);
  const auto row = [&](const char* name, std::size_t ours, const char* peer, std::size_t peers) {
    const auto us = [&](std::size_t i) { return 1e6 * median(run[i].cpu_s) / kBlocks; };
    tell(name, "us/block", us(ours), peer, us(peers), ratio(run[ours], run[peers]));
  };
  row("link, seal to delivery", 0, "raw UDP, same datagrams", 1);
  row("link, acknowledged block by block", 3, "raw UDP, one at a time", 4);
  row("link beside LCM", 0, "LCM alone, same messages", 2);
}

}  // namespace
}  // namespace roadbalance::bench

int main() {
  try {
    roadbalance::bench::run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench-link: %s\n", error.what());
    return 4;
  }
}
