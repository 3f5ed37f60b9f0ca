#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/bus/bus_route.hpp"
#include "common/types/block.hpp"

namespace roadbalance {

/// Names of LCM channels.  Blocks: "RB_BLOCK_<node>_<KIND>", e.g. RB_BLOCK_1_SCAN; control:
/// RB_HEARTBEAT_<node>, RB_ACK_<node>, RB_COMMAND_<node>, RB_REPLY_<node>, RB_VEHICLE_<node>; preview:
/// RB_PREVIEW_<node>; results: RB_LEVEL, RB_SPECTRUM, RB_IDENTIFICATION, RB_BALANCE.
inline constexpr const char* kBlockChannels = "RB_BLOCK_";  ///< what those of all blocks begin with
std::string block_channel(int node, BlockKind kind);
std::string preview_channel(int node);
std::string heartbeat_channel(int node);
std::string ack_channel(int node);
std::string command_channel(int node);
std::string reply_channel(int node);
std::string vehicle_channel(int node);
inline constexpr const char* kLevelChannel = "RB_LEVEL";
inline constexpr const char* kSpectrumChannel = "RB_SPECTRUM";
inline constexpr const char* kIdentificationChannel = "RB_IDENTIFICATION";
inline constexpr const char* kBalanceChannel = "RB_BALANCE";

/// The environment variable from which LCM's own programs, too, take their address.
inline constexpr const char* kBusUrlVariable = "LCM_DEFAULT_URL";
/// The bus that a program is on unless another is given: the environment's, or else LCM's own, TTL 0.
std::string default_bus_url();
/// LCM's own on another port; only the port isolates two buses.
std::string bus_url_on_port(int port);

/// The command that a computer without a network needs once, as root: LCM speaks multicast even to itself.
inline constexpr const char* kMulticastRemedy = "ip link set lo up && ip route add 224.0.0.0/4 dev lo";

/// One process's access to the bus.  Not shared between threads: each process owns its own.
///
/// Sends by LCM, but for messages that are gathered (MessageRun), and receives what LCM sends as messages of
/// one packet (MessageSocket).  Messages wait in the socket's receive buffer until they are handled.
class Bus {
 public:
  struct Options {
    /// Takes all that is on the bus out of the kernel, so that dropped() counts what was no message and what
    /// found no room.  Without it messages on channels that nobody here has subscribed to stay there.
    bool hears_all = false;
    /// A thread empties the socket meanwhile, for those who may be busy for longer than the socket can hold,
    /// and keeps up to so many bytes.
    std::size_t ahead_bytes = 0;
  };
  using Handler = std::function<void(std::string_view channel, std::span<const std::uint8_t> bytes)>;

  /// @throws std::runtime_error naming the URL, and the remedy where there is no multicast route
  explicit Bus(const std::string& url, const Options& options);
  explicit Bus(const std::string& url) : Bus(url, Options{}) {}
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// All subscriptions come before the first handle(), from which on only what they ask for takes room.
  /// @param pattern  a channel's name, or the beginning of names with ".*" behind it
  /// @throws std::invalid_argument naming a pattern that is neither, std::runtime_error naming the URL, e.g.
  ///         if another program has the port for itself
  void subscribe(const std::string& pattern, Handler handler);

  /// False if the datagram could not be sent; nobody learns whether it arrived.
  bool publish(const std::string& channel, std::span<const std::uint8_t> bytes);

  /// From now on messages on channels that begin so wait for others like them, to be sent together where the
  /// computer can (MessageRun); publish() of one that waits gives true.  Messages that still wait when the
  /// bus goes are not sent.
  void gather(std::string beginning);
  /// Sends those that wait, and lets none wait any more.  Returns how many, since gather(), could not be
  /// sent.
  std::size_t send_gathered();

  /// Waits up to `timeout` for a message, then handles all that have arrived.  Returns how many.  Messages
  /// behind one whose handler throws are handled by the next call.
  /// @throws std::runtime_error naming the URL if nothing can be received any more, and what a handler threw
  int handle(std::chrono::milliseconds timeout);

  /// Datagrams that never came this far: no message of one packet, or no room left (see Options::hears_all).
  std::int64_t dropped() const;

  /// Bytes that wait to be handled at most, by what the kernel gave (see MessageSocket); 0 without a
  /// subscription.
  std::int64_t receive_buffer() const;

  /// For people, since the last call: who on the subscribed channels is of another version of the wire (see
  /// OtherWire).
  std::vector<std::string> other_versions();
  /// Nodes that have spoken another version since the last call.
  std::set<std::int32_t> nodes_of_other_versions();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roadbalance
