#include "tools/rb/machine.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include "common/bus/bus.hpp"

namespace roadbalance {
namespace {

std::string read_all(const char* path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The folder itself, or the nearest one above it that exists: where it would be created.
std::filesystem::path existing_part(std::filesystem::path folder) {
  folder = std::filesystem::absolute(folder);
  while (!std::filesystem::exists(folder) && folder.has_relative_path()) folder = folder.parent_path();
  return folder;
}

}  // namespace

// Columns: interface, destination, gateway, flags, ..., mask (8th), hexadecimal, least significant byte
// first.
bool has_multicast_route(const std::string& route_table) {
  std::istringstream lines(route_table);
  std::string line;
  std::getline(lines, line);  // header
  while (std::getline(lines, line)) {
    std::istringstream columns(line);
    std::array<std::string, 8> column;
    for (auto& text : column) columns >> text;
    if (column[1] == "00000000" || (column[1] == "000000E0" && column[7] == "000000F0")) return true;
  }
  return false;
}

Finding multicast_route(const std::string& route_table) {
  if (has_multicast_route(route_table))
    return {"multicast_route", Finding::kWell, "There is a route for multicast, which LCM needs.", ""};
  return {"multicast_route", Finding::kIll,
          "There is no route for multicast (224.0.0.0/4), which LCM needs even on one machine.",
          "sudo ip link set lo up; sudo ip route add 224.0.0.0/4 dev lo"};
}

Finding receive_buffer(std::int64_t rmem_max_bytes) {
  const std::string is = "net.core.rmem_max is " + std::to_string(rmem_max_bytes) + " bytes";
  if (rmem_max_bytes >= kReceiveBufferBytes)
    return {"receive_buffer", Finding::kWell, is + ", enough for the bus.", ""};
  return {"receive_buffer", Finding::kNote,
          is + ", less than the 4 MiB that let a busy recorder listen without asking for repeats.",
          "sudo sysctl -w net.core.rmem_max=" + std::to_string(kReceiveBufferBytes)};
}

Finding writable_folder(const std::filesystem::path& folder) {
  const std::string place = existing_part(folder).string();
  // Only a file tells: permission bits say nothing of a read-only disk.
  std::string probe = place + "/.rb-doctor-XXXXXX";
  const int file = mkstemp(probe.data());
  if (file >= 0) {
    close(file);
    unlink(probe.c_str());
  }
  if (file >= 0)
    return {"folder", Finding::kWell, "Recordings can be written to " + folder.string() + ".", ""};
  return {"folder", Finding::kIll,
          "Recordings cannot be written to " + folder.string() + ": " + place + " takes no new file.",
          "sudo chown \"$USER\" '" + place + "'"};
}

Finding realtime_priority(std::int64_t limit, bool root) {
  if (root || limit > 0) return {"realtime", Finding::kWell, "A node may run with real-time priority.", ""};
  return {
      "realtime", Finding::kNote,
      "A node may not run with real-time priority; its ring then has to outlast a busy machine.",
      "echo \"$USER - rtprio 50\" | sudo tee /etc/security/limits.d/roadbalance.conf  # then log in again"};
}

Finding loopback(int port) {
  const std::string remedy = "sudo ip link set lo up; sudo ip route add 224.0.0.0/4 dev lo";
  try {
    Bus sender(bus_url_on_port(port));
    Bus receiver(bus_url_on_port(port));
    bool heard = false;
    receiver.subscribe("RB_DOCTOR", [&](std::string_view, std::span<const std::uint8_t>) { heard = true; });
    const std::array<std::uint8_t, 4> greeting{};
    for (int attempt = 0; attempt < 10 && !heard; ++attempt) {
      sender.publish("RB_DOCTOR", greeting);
      receiver.handle(std::chrono::milliseconds(100));
    }
    if (heard) return {"loopback", Finding::kWell, "A message sent over LCM comes back on this machine.", ""};
    return {"loopback", Finding::kIll,
            "A message sent over LCM does not come back on this machine; a firewall may block it.", remedy};
  } catch (const std::exception& error) {
    return {"loopback", Finding::kIll, std::string("LCM does not start: ") + error.what(), remedy};
  }
}

std::vector<Finding> examine_machine(const std::filesystem::path& folder) {
  std::int64_t rmem_max = 0;
  std::istringstream(read_all("/proc/sys/net/core/rmem_max")) >> rmem_max;
  rlimit limit{};
  getrlimit(RLIMIT_RTPRIO, &limit);
  const auto priority = limit.rlim_cur == RLIM_INFINITY ? 99 : static_cast<std::int64_t>(limit.rlim_cur);
  return {multicast_route(read_all("/proc/net/route")), receive_buffer(rmem_max), writable_folder(folder),
          realtime_priority(priority, geteuid() == 0), loopback(20'000 + getpid() % 20'000)};
}

}  // namespace roadbalance
