#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace roadbalance {

/// One thing a measurement needs of the machine, in one sentence.
struct Finding {
  enum State { kWell, kNote, kIll };  ///< note: works, though not as well as it could
  std::string name;
  State state = kWell;
  std::string sentence;
  std::string remedy;  ///< the command that mends it; empty if well
};

/// The bytes that the recorder wants to buffer while it is kept from reading.
inline constexpr std::int64_t kReceiveBufferBytes = 4 << 20;

/// True if the routing table (the text of /proc/net/route) has a way for 224.0.0.0/4.
bool has_multicast_route(const std::string& route_table);

Finding multicast_route(const std::string& route_table);
Finding receive_buffer(std::int64_t rmem_max_bytes);
Finding writable_folder(const std::filesystem::path& folder);
/// @param limit  RLIMIT_RTPRIO of this process; @param root  whether it is root
Finding realtime_priority(std::int64_t limit, bool root);
/// Sends itself a message over LCM on this port.
Finding loopback(int port);

/// All of them on this machine.
std::vector<Finding> examine_machine(const std::filesystem::path& folder);

}  // namespace roadbalance
