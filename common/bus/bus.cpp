#include "common/bus/bus.hpp"

#include <arpa/inet.h>
#include <lcm/lcm.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <limits>
#include <list>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "common/bus/datagram_filter.hpp"
#include "common/bus/other_wire.hpp"

namespace roadbalance {
namespace {

std::string_view name_of(BlockKind kind) {
  switch (kind) {
    case BlockKind::kScan:
      return "SCAN";
    case BlockKind::kEdge:
      return "EDGE";
    case BlockKind::kGap:
      return "GAP";
    case BlockKind::kMeta:
      return "META";
    case BlockKind::kEnd:
      return "END";
    case BlockKind::kSignal:
      return "SIGNAL";
  }
  return "UNKNOWN";
}

constexpr std::uint16_t kDefaultPort = 7667;  // LCM's

// Asks the kernel for the way to the bus; nothing is sent.
bool has_multicast_route() {
  sockaddr_in group{};
  group.sin_family = AF_INET;
  group.sin_port = htons(kDefaultPort);
  group.sin_addr.s_addr = inet_addr("239.255.76.67");
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return true;  // the fault is another one
  const bool found = ::connect(descriptor, reinterpret_cast<const sockaddr*>(&group), sizeof group) == 0;
  ::close(descriptor);
  return found;
}

[[noreturn]] void throw_no_bus(const std::string& url, const std::string& what) {
  const int error = errno;
  std::string why = error == 0 ? "not an LCM address that can be used" : std::strerror(error);
  if (url.starts_with("udpm:") && !has_multicast_route())
    why = std::string("there is no multicast route; sudo sh -c '") + kMulticastRemedy + "'";
  throw std::runtime_error("cannot " + what + " LCM bus " + url + ": " + why);
}

// "udpm://ADDRESS[:PORT][?...]" as LCM reads it; nothing if the bus is no socket.
std::optional<std::uint16_t> port_of(const std::string& url) {
  constexpr std::string_view kScheme = "udpm://";
  if (!url.starts_with(kScheme)) return std::nullopt;
  const std::string target = url.substr(kScheme.size(), url.find('?') - kScheme.size());
  const auto colon = target.find(':');
  if (colon == std::string::npos) return kDefaultPort;
  return static_cast<std::uint16_t>(std::strtol(target.c_str() + colon + 1, nullptr, 0));
}

// A caller with other duties gets control back after this many messages, however fast they come.
constexpr int kMostPerCall = 4096;

}  // namespace

std::string block_channel(int node, BlockKind kind) {
  // Each block's is asked for several times: written in place, which is three times as fast as adding
  // strings.
  std::array<char, 32> name{'R', 'B', '_', 'B', 'L', 'O', 'C', 'K', '_'};
  char* end = std::to_chars(name.data() + 9, name.data() + name.size(), node).ptr;
  *end++ = '_';
  const std::string_view of_kind = name_of(kind);
  end = std::copy(of_kind.begin(), of_kind.end(), end);
  return {name.data(), end};
}
std::string preview_channel(int node) {
  return "RB_PREVIEW_" + std::to_string(node);
}
std::string heartbeat_channel(int node) {
  return "RB_HEARTBEAT_" + std::to_string(node);
}
std::string ack_channel(int node) {
  return "RB_ACK_" + std::to_string(node);
}
std::string command_channel(int node) {
  return "RB_COMMAND_" + std::to_string(node);
}
std::string reply_channel(int node) {
  return "RB_REPLY_" + std::to_string(node);
}

std::string vehicle_channel(int node) {
  return "RB_VEHICLE_" + std::to_string(node);
}

std::string default_bus_url() {
  return bus_url_on_port(kDefaultPort);
}

std::string bus_url_on_port(int port) {
  return "udpm://239.255.76.67:" + std::to_string(port) +
         "?ttl=0&recv_buf_size=" + std::to_string(kReceiveBufferBytes);
}

struct Bus::State {
  // LCM calls back from C: an exception waits here until its frames are gone.
  struct Subscription {
    Handler handler;
    std::exception_ptr* failure;
    OtherWire* other_wire;
  };

  std::string url;
  lcm_t* lcm = nullptr;
  std::list<Subscription> subscriptions;
  std::exception_ptr failure;
  DatagramFilter filter;
  OtherWire other_wire;

  ~State() {
    if (lcm) lcm_destroy(lcm);
  }

  static void on_message(const lcm_recv_buf_t* received, const char* channel, void* user) {
    auto& subscription = *static_cast<Subscription*>(user);
    const std::span bytes(static_cast<const std::uint8_t*>(received->data), received->data_size);
    try {
      subscription.other_wire->take(channel, bytes);
      subscription.handler(channel, bytes);
    } catch (...) {
      *subscription.failure = std::current_exception();
    }
  }
};

Bus::Bus(const std::string& url) : state_(std::make_unique<State>()) {
  state_->url = url;
  errno = 0;
  state_->lcm = lcm_create(url.c_str());
  if (!state_->lcm) throw_no_bus(url, "open");
}

Bus::~Bus() = default;

void Bus::subscribe(const std::string& pattern, Handler handler) {
  auto& subscription = state_->subscriptions.emplace_back(
      State::Subscription{std::move(handler), &state_->failure, &state_->other_wire});
  // LCM opens its socket with the first subscription.  One at a time, so that the socket without a filter is
  // this bus's.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  errno = 0;
  auto* handle = lcm_subscribe(state_->lcm, pattern.c_str(), &State::on_message, &subscription);
  if (!handle) throw_no_bus(state_->url, "subscribe to " + pattern + " on");
  const auto port = port_of(state_->url);
  if (port && state_->filter.sockets() == 0) state_->filter.attach(*port);
  lcm_subscription_set_queue_capacity(handle, 0);
}

bool Bus::publish(const std::string& channel, std::span<const std::uint8_t> bytes) {
  if (bytes.size() > std::numeric_limits<unsigned>::max()) return false;
  return lcm_publish(state_->lcm, channel.c_str(), bytes.data(), static_cast<unsigned>(bytes.size())) == 0;
}

std::int64_t Bus::dropped() const {
  return state_->filter.dropped();
}

std::vector<std::string> Bus::other_versions() {
  return state_->other_wire.sentences();
}

std::set<std::int32_t> Bus::nodes_of_other_versions() {
  return state_->other_wire.nodes();
}

int Bus::handle(std::chrono::milliseconds timeout) {
  int handled = 0;
  auto wait = static_cast<int>(timeout.count());
  while (handled < kMostPerCall) {
    errno = 0;
    const int result = lcm_handle_timeout(state_->lcm, wait);
    if (state_->failure) std::rethrow_exception(std::exchange(state_->failure, nullptr));
    if (result < 0 && errno != EINTR) throw_no_bus(state_->url, "receive from");
    if (result <= 0) break;
    ++handled;
    wait = 0;
  }
  return handled;
}

}  // namespace roadbalance
