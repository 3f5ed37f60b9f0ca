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
#include <limits>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "common/bus/message_run.hpp"
#include "common/bus/message_socket.hpp"
#include "common/bus/other_wire.hpp"
#include "common/bus/read_ahead.hpp"

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

// Asks the kernel for the way to the bus; nothing is sent.
bool has_multicast_route() {
  constexpr BusAddress kBus;
  sockaddr_in group{};
  group.sin_family = AF_INET;
  group.sin_port = htons(kBus.port);
  group.sin_addr.s_addr = htonl(kBus.group);
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return true;  // the fault is another one
  const bool found = ::connect(descriptor, reinterpret_cast<const sockaddr*>(&group), sizeof group) == 0;
  ::close(descriptor);
  return found;
}

/// As the environment has it; empty: it has none.
std::string url_of_environment() {
  const char* const url = std::getenv(kBusUrlVariable);
  return url ? url : "";
}

[[noreturn]] void throw_no_bus(const std::string& url, const std::string& what, int error) {
  std::string why = error == 0 ? "not an LCM address that can be used" : std::strerror(error);
  if (url.starts_with("udpm:") && !has_multicast_route())
    why = std::string("there is no multicast route; sudo sh -c '") + kMulticastRemedy + "'";
  const bool is_of_environment = !url.empty() && url == url_of_environment();
  const std::string whose = is_of_environment ? std::string(" of ") + kBusUrlVariable : "";
  throw std::runtime_error("cannot " + what + " LCM bus " + url + whose + ": " + why);
}

// A caller with other duties gets control back after this many messages, however fast they come, and whether
// or not somebody here wants them.
constexpr int kMostPerCall = 4096;

}  // namespace

std::string block_channel(int node, BlockKind kind) {
  // Each block's is asked for several times: written in place, which is three times as fast as adding
  // strings.
  std::array<char, 32> name{};
  constexpr std::string_view kBeginning = kBlockChannels;
  char* end = std::copy(kBeginning.begin(), kBeginning.end(), name.data());
  end = std::to_chars(end, name.data() + name.size(), node).ptr;
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
  const std::string url = url_of_environment();
  return url.empty() ? bus_url_on_port(BusAddress{}.port) : url;
}

std::string bus_url_on_port(int port) {
  return "udpm://239.255.76.67:" + std::to_string(port) + "?ttl=0";
}

struct Bus::State {
  struct Subscription {
    Channels channels;
    Handler handler;
  };

  std::string url;
  std::optional<BusAddress> address;  ///< nothing if it is no bus over UDP
  Options options;
  lcm_t* lcm = nullptr;  ///< sends
  std::vector<Subscription> subscriptions;
  std::optional<MessageSocket> socket;  ///< opened for the first subscription, as are the next two
  std::optional<MessageBatch> batch;    ///< being handled, of who does not read ahead
  std::unique_ptr<HeldMessages> held;   ///< the same, of who does
  std::optional<ReadAhead> ahead;       ///< begun by the first handle()
  bool listening = false;               ///< begun by the first handle()
  OtherWire other_wire;
  std::optional<std::string> gathered;  ///< what channels begin with whose messages wait
  std::optional<MessageRun> run;        ///< those that wait; opened for the first
  std::size_t unsent = 0;               ///< since gather()

  ~State() {
    if (lcm) lcm_destroy(lcm);
  }

  /// Over a network those who want some of it would have to look at all of it.
  Runs runs() const { return options.hears_all || address->ttl == 0 ? Runs::kWhole : Runs::kCut; }

  void open_socket() {
    socket.emplace(*address, runs());
    if (options.ahead_bytes > 0)
      held = std::make_unique<HeldMessages>();
    else
      batch.emplace(socket->runs());
  }

  Messages& waiting() { return held ? static_cast<Messages&>(*held) : *batch; }
  /// Whether more may have come together with those.
  bool more_behind() const { return held || batch->full(); }

  bool publish(const std::string& channel, std::span<const std::uint8_t> bytes) {
    return bytes.size() <= std::numeric_limits<unsigned>::max() &&
           lcm_publish(lcm, channel.c_str(), bytes.data(), static_cast<unsigned>(bytes.size())) == 0;
  }

  void send_run() {
    if (run) unsent += run->send();
  }

  /// True if somebody here has subscribed to it.
  bool hand_on(const Message& message) {
    bool wanted = false;
    for (Subscription& one : subscriptions) {
      if (!one.channels.has(message.channel)) continue;
      if (!std::exchange(wanted, true)) other_wire.take(message.channel, message.bytes);
      one.handler(message.channel, message.bytes);
    }
    return wanted;
  }

  /// Once for all: each filter counts towards what a socket may hold (net.core.optmem_max) until the one that
  /// takes its place is attached.
  void hear_only_subscribed() {
    std::vector<Channels> all;
    for (const Subscription& one : subscriptions)
      if (std::find(all.begin(), all.end(), one.channels) == all.end()) all.push_back(one.channels);
    socket->hear_only(all);
  }

  /// In place of what waited, all of which has been handled, what comes within `timeout`; false if nothing
  /// did.
  bool receive(std::chrono::milliseconds timeout) {
    if (!std::exchange(listening, true) && !options.hears_all) hear_only_subscribed();
    if (held) {
      if (!ahead) ahead.emplace(*socket, options.ahead_bytes);
      return ahead->swap(held, timeout);
    }
    batch->clear();
    return (timeout.count() == 0 || socket->wait(timeout)) && socket->receive(*batch);
  }
};

Bus::Bus(const std::string& url, const Options& options) : state_(std::make_unique<State>()) {
  state_->url = url;
  state_->address = bus_address(url);
  state_->options = options;
  errno = 0;
  state_->lcm = lcm_create(url.c_str());
  if (!state_->lcm) throw_no_bus(url, "open", errno);
}

Bus::~Bus() = default;

void Bus::subscribe(const std::string& pattern, Handler handler) {
  const Channels channels(pattern);
  if (!state_->address) throw_no_bus(state_->url, "subscribe to " + pattern + " on", 0);
  try {
    if (!state_->socket) state_->open_socket();
  } catch (const std::system_error& error) {
    throw_no_bus(state_->url, "subscribe to " + pattern + " on", error.code().value());
  }
  state_->subscriptions.push_back({channels, std::move(handler)});
}

bool Bus::publish(const std::string& channel, std::span<const std::uint8_t> bytes) {
  State& state = *state_;
  if (!state.gathered) return state.publish(channel, bytes);
  const bool waits = state.run && channel.starts_with(*state.gathered);
  if (waits && state.run->add(channel, bytes)) return true;
  state.send_run();  // what was published before is sent before
  return (waits && state.run->add(channel, bytes)) || state.publish(channel, bytes);
}

void Bus::gather(std::string beginning) {
  try {
    if (!state_->run && state_->address) state_->run.emplace(*state_->address);
  } catch (const std::system_error&) {
    // Until there is a socket for them, they go by LCM's.
  }
  state_->gathered = std::move(beginning);
  state_->unsent = 0;
}

std::size_t Bus::send_gathered() {
  state_->send_run();
  state_->gathered.reset();
  return std::exchange(state_->unsent, 0);
}

std::int64_t Bus::dropped() const {
  return state_->socket ? state_->socket->dropped() : 0;
}

std::int64_t Bus::receive_buffer() const {
  return state_->socket ? state_->socket->receive_buffer() : 0;
}

std::vector<std::string> Bus::other_versions() {
  return state_->other_wire.sentences();
}

std::set<std::int32_t> Bus::nodes_of_other_versions() {
  return state_->other_wire.nodes();
}

int Bus::handle(std::chrono::milliseconds timeout) {
  using std::chrono::milliseconds, std::chrono::steady_clock;
  if (!state_->socket) {
    std::this_thread::sleep_for(timeout);
    return 0;
  }
  const auto end = steady_clock::now() + timeout;
  int handled = 0, taken = 0;
  for (bool more = true; taken < kMostPerCall;) {
    if (!state_->waiting().empty()) {
      ++taken;
      handled += state_->hand_on(state_->waiting().take()) ? 1 : 0;
      continue;
    }
    if (handled > 0 && !more) break;
    const auto left = std::chrono::ceil<milliseconds>(end - steady_clock::now());
    try {
      if (!state_->receive(handled > 0 ? milliseconds(0) : std::max(left, milliseconds(0)))) break;
    } catch (const std::system_error& error) {
      throw_no_bus(state_->url, "receive from", error.code().value());
    }
    more = state_->more_behind();
  }
  return handled;
}

}  // namespace roadbalance
