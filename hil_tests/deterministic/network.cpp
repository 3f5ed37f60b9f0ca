#include "hil_tests/deterministic/network.hpp"

#include <algorithm>
#include <array>

#include "common/bus/bus.hpp"
#include "common/bus/operation.hpp"

namespace roadbalance::test {
namespace {
constexpr std::size_t kMostHosts = 4;
constexpr double kMillisecond_ns = 1e6;
}  // namespace

void Network::add_node(std::int32_t number) {
  cables_.push_back({.ack = ack_channel(number),
                     .command = command_channel(number),
                     .vehicle = vehicle_channel(number),
                     .out = {}});
}

void Network::pull(std::size_t node, Direction direction, bool out) {
  auto& count = cables_[node].out;
  if (direction != Direction::kToNode) count[0] += out ? 1 : -1;
  if (direction != Direction::kToHost) count[1] += out ? 1 : -1;
}

int Network::copies(double loss) {
  int copies = random_.chance(loss) ? 0 : 1;
  if (random_.chance(scenario_.duplicates) && !random_.chance(loss)) ++copies;
  return copies;
}

void Network::arrive(Event::Kind kind, std::size_t who, std::uint32_t datagram, int copies,
                     std::int64_t now_ns) {
  for (int copy = 0; copy < copies; ++copy) {
    const double late_ms = random_.chance(scenario_.reordered) ? random_.between(5, 50) : 0;
    const double ms = random_.between(0.1, 2) + late_ms;
    events_.add(now_ns + static_cast<std::int64_t>(ms * kMillisecond_ns), kind, who, datagram);
  }
}

void Network::from_node(std::size_t node, const std::string& channel, std::span<const std::uint8_t> bytes,
                        std::int64_t now_ns) {
  if (channel.starts_with(kBlockChannels))
    ++blocks_sent_;
  else if (channel.starts_with("RB_PREVIEW_"))
    return;  // no recorder listens
  if (cables_[node].out[0] > 0) return;
  std::array<int, kMostHosts> to{};
  int all = 0;
  for (std::size_t host = 0; host < static_cast<std::size_t>(scenario_.hosts); ++host)
    all += to[host] = copies(scenario_.loss_to_host);
  if (all == 0) return;
  const std::uint32_t datagram = datagrams_.add(channel, bytes, all);
  for (std::size_t host = 0; host < static_cast<std::size_t>(scenario_.hosts); ++host)
    arrive(Event::Kind::kToHost, host, datagram, to[host], now_ns);
}

void Network::from_asker(const std::string& channel, std::span<const std::uint8_t> bytes,
                         std::int64_t now_ns) {
  const int sent = copies(scenario_.loss_to_host);
  if (sent > 0) arrive(Event::Kind::kToHost, 0, datagrams_.add(channel, bytes, sent), sent, now_ns);
}

void Network::from_host(std::size_t, const std::string& channel, std::span<const std::uint8_t> bytes,
                        std::int64_t now_ns) {
  if (channel == kAnswerChannel) {
    const int sent = copies(scenario_.loss_to_node);
    if (sent > 0) arrive(Event::Kind::kToAskers, 0, datagrams_.add(channel, bytes, sent), sent, now_ns);
    return;
  }
  for (std::size_t node = 0; node < cables_.size(); ++node) {
    const Cable& cable = cables_[node];
    if ((channel != cable.ack && channel != cable.command && channel != cable.vehicle) || cable.out[1] > 0)
      continue;
    const int sent = copies(scenario_.loss_to_node);
    if (sent > 0) arrive(Event::Kind::kToNode, node, datagrams_.add(channel, bytes, sent), sent, now_ns);
  }
}

bool Network::exchange(std::size_t node) {
  const auto& out = cables_[node].out;
  return out[0] == 0 && out[1] == 0 && !random_.chance(scenario_.loss_to_node) &&
         !random_.chance(scenario_.loss_to_host);
}

}  // namespace roadbalance::test
