#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/bus_route.hpp"
#include "tools/doctor/finding.hpp"

namespace roadbalance {

/// True if what is sent to that bus goes to no other machine.
bool stays_on_machine(const std::string& url);

/// Commands that give a computer without a network a route for multicast, for now and for good.
std::string multicast_remedy();

/// The interface over which datagrams to a bus's group go.
/// @param route_table  as /proc/net/route
/// @return of the routes that hold the group the narrowest, of several the one with the least metric; nothing
///         if there is none, or if it is a route to nowhere
std::optional<std::string> multicast_interface(const std::string& route_table,
                                               std::uint32_t group = BusAddress{}.group);

/// The kernel's properties of a network interface; those that it does not report are empty.
struct NetworkInterface {
  std::string name;
  std::optional<int> mtu_bytes{}, speed_mbit_s{};
  bool wireless = false;
  bool unplugged = false;
};
NetworkInterface network_interface(const std::string& name, const std::filesystem::path& sys = "/sys");

/// The way to a bus: one finding if all is well, else one for each thing that is not.
/// @param interface  of multicast_interface(); nothing: there is no way
/// @param stays_on_machine  what is sent: then cable and radio do not matter
std::vector<Finding> way_findings(const std::optional<NetworkInterface>& interface, bool stays_on_machine);
/// The same of this machine.  @param url  of the bus; empty: of any
/// @param proc, sys  where the kernel's trees are, here and below
std::vector<Finding> examine_way(const std::string& url, const std::filesystem::path& proc = "/proc",
                                 const std::filesystem::path& sys = "/sys");

/// @param granted_bytes  that a socket of the bus really got
Finding receive_buffer(std::int64_t granted_bytes, const std::filesystem::path& proc = "/proc");

}  // namespace roadbalance
