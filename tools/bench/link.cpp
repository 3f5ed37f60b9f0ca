#include <arpa/inet.h>
#include <lcm/lcm.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/control.hpp"
#include "common/bus/process_port.hpp"
#include "common/link/receiver.hpp"
#include "common/link/sender.hpp"
#include "tools/bench/contest.hpp"

// The loss-free link from a sealed block to one that the recorder may write, beside the same datagrams over
// bare UDP and over LCM with nothing of ours: lines of JSON as bench-peers.  Both ends are in this program
// and take turns.

namespace roadbalance::bench {
namespace {

using namespace std::chrono_literals;
constexpr int kBurst = 32, kBursts = 16;  // blocks, and bursts a call
constexpr std::int64_t kEpoch = 9, kOwner = 1;

ScanBlock scans() {
  ScanBlock block;
  for (std::size_t row = 0; row < block.counts.size(); ++row)
    for (std::size_t c = 0; c < block.counts[row].size(); ++c)
      block.counts[row][c] = static_cast<std::int32_t>(7919 * row + 104'729 * c);
  block.period_ps = 500'000'000;
  return block;
}

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

  void burst() {
    for (int k = 0; k < kBurst; ++k) {
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
    for (const std::int64_t sequence : sender_.due(now_))
      if (const SealedBlock* block = backlog_.get(sequence)) node_.publish(channel_, block->bytes());
    while (delivered_.size() < kBurst)
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
  Bus node_{url_}, recorder_{url_};
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

/// Multicast on loopback and back, a burst at a time.
class BareUdp {
 public:
  explicit BareUdp(std::size_t bytes) : datagram_(bytes) {
    const int reuse = 1, room = 4 << 20;
    ::setsockopt(in_, SOL_SOCKET, SO_REUSEADDR, &reuse, sizeof reuse);
    ::setsockopt(in_, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    group_.sin_family = AF_INET;
    group_.sin_port = htons(static_cast<std::uint16_t>(process_port(1)));
    group_.sin_addr.s_addr = inet_addr("239.255.76.67");
    ip_mreq join{};
    join.imr_multiaddr = group_.sin_addr;
    const unsigned char ttl = 0;
    ::setsockopt(out_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
    if (::bind(in_, reinterpret_cast<const sockaddr*>(&group_), sizeof group_) != 0 ||
        ::setsockopt(in_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &join, sizeof join) != 0)
      throw std::runtime_error("no socket for the bare datagrams");
  }
  ~BareUdp() {
    ::close(in_);
    ::close(out_);
  }
  BareUdp(const BareUdp&) = delete;
  BareUdp& operator=(const BareUdp&) = delete;

  void burst() {
    const auto size = static_cast<ssize_t>(datagram_.size());
    for (int k = 0; k < kBurst; ++k)
      if (::sendto(out_, datagram_.data(), datagram_.size(), 0, reinterpret_cast<const sockaddr*>(&group_),
                   sizeof group_) != size)
        throw std::runtime_error("a bare datagram was not sent");
    for (int k = 0; k < kBurst; ++k)
      if (::recv(in_, datagram_.data(), datagram_.size(), 0) != size)
        throw std::runtime_error("a bare datagram did not come");
  }

 private:
  std::vector<std::uint8_t> datagram_;
  sockaddr_in group_{};
  int in_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0),
      out_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
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
  void burst() {
    for (int k = 0; k < kBurst; ++k)
      lcm_publish(out_.get(), "BLOCK", message_.data(), static_cast<unsigned>(message_.size()));
    for (seen_ = 0; seen_ < kBurst;)
      if (lcm_handle_timeout(in_.get(), 1000) <= 0) throw std::runtime_error("a bare message did not come");
  }

 private:
  using Lcm = std::unique_ptr<lcm_t, decltype(&lcm_destroy)>;
  const std::string url_ = bus_url_on_port(process_port(2));
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
  std::vector<Contender> run(3);
  run[0].work = [&] {
    for (int k = 0; k < kBursts; ++k) link.burst();
  };
  run[1].work = [&] {
    for (int k = 0; k < kBursts; ++k) bare.burst();
  };
  run[2].work = [&] {
    for (int k = 0; k < kBursts; ++k) lcm.burst();
  };
  compete(run);
  const auto us = [&](std::size_t i) { return 1e6 * median(run[i].cpu_s) / (kBurst * kBursts); };
  const char* const unit = "us/block";
  tell("link, seal to delivery", unit, us(0), "raw UDP, same datagrams", us(1), ratio(run[0], run[1]));
  tell("link beside LCM", unit, us(0), "LCM alone, same messages", us(2), ratio(run[0], run[2]));
  tell("LCM alone", unit, us(2), "raw UDP, same datagrams", us(1), ratio(run[2], run[1]));
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
