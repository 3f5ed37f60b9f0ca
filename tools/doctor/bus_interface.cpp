#include "tools/doctor/bus_interface.hpp"

#include <arpa/inet.h>

#include <array>
#include <bit>
#include <charconv>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>
#include <tuple>

#include "common/bus/bus.hpp"
#include "common/text/format.hpp"

namespace roadbalance {
namespace {

/// A block of scans on a cable: headers of IPv4 (20) and UDP (8), LCM's with the channel's name (24), and
/// scan_block_t.
constexpr int kFrameBytes = 1404;
constexpr int kLeastSpeed_mbit_s = 100;

std::optional<std::uint32_t> number_of(const std::string& text, int base) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<int> number_in(const std::filesystem::path& file) {
  int number = 0;
  if (!(std::ifstream(file) >> number)) return std::nullopt;
  return number;
}

}  // namespace

bool stays_on_machine(const std::string& url) {
  const auto bus = bus_address(url);
  return bus && bus->ttl == 0;
}

std::string multicast_remedy() {
  return std::string("sudo sh -c '") + kMulticastRemedy +
         "'  # for good: \"up ip route add 224.0.0.0/4 dev lo\" below \"iface lo\" in "
         "/etc/network/interfaces";
}

// Columns: interface, destination, gateway, flags, ..., metric (7th), mask (8th); addresses are hexadecimal,
// of the bytes as they are sent read as a number of this machine's.
std::optional<std::string> multicast_interface(const std::string& route_table, std::uint32_t group) {
  constexpr std::uint32_t kNoWay = 0x200;  // RTF_REJECT
  std::istringstream lines(route_table);
  std::string line;
  std::getline(lines, line);  // header
  std::optional<std::tuple<int, std::int64_t>> best;
  std::optional<std::string> interface;
  while (std::getline(lines, line)) {
    std::istringstream columns(line);
    std::array<std::string, 8> column;
    for (auto& text : column) columns >> text;
    const auto destination = number_of(column[1], 16), flags = number_of(column[3], 16),
               metric = number_of(column[6], 10), mask = number_of(column[7], 16);
    if (!destination || !flags || !metric || !mask || (htonl(group) & *mask) != *destination) continue;
    const std::tuple rank(std::popcount(*mask), -static_cast<std::int64_t>(*metric));
    if (best && rank <= *best) continue;
    best = rank;
    interface = (*flags & kNoWay) == 0 ? std::optional(column[0]) : std::nullopt;
  }
  return interface;
}

NetworkInterface network_interface(const std::string& name, const std::filesystem::path& sys) {
  const auto folder = sys / "class/net" / name;
  NetworkInterface found{.name = name, .mtu_bytes = number_in(folder / "mtu")};
  if (const auto speed = number_in(folder / "speed"); speed > 0) found.speed_mbit_s = speed;
  found.wireless =
      std::filesystem::exists(folder / "wireless") || std::filesystem::exists(folder / "phy80211");
  found.unplugged = number_in(folder / "carrier") == 0;
  return found;
}

std::vector<Finding> way_findings(const std::optional<NetworkInterface>& interface, bool stays_on_machine) {
  constexpr const char* kName = "multicast_route";
  if (!interface)
    return {{kName, Finding::kIll,
             "There is no route for multicast (224.0.0.0/4), which LCM needs even on one machine.",
             multicast_remedy()}};
  const std::string& name = interface->name;
  std::vector<Finding> findings;
  const auto note = [&](const char* what, const std::string& sentence, const std::string& remedy) {
    findings.push_back({what, Finding::kNote, sentence, remedy});
  };
  if (interface->mtu_bytes && *interface->mtu_bytes < kFrameBytes)
    note("mtu",
         format("%s carries %d bytes at a time: a block (%d) goes in pieces, and is lost with any of them.",
                name.c_str(), *interface->mtu_bytes, kFrameBytes),
         "sudo ip link set dev " + name + " mtu 1500  # for good: \"mtu 1500\" in the network's settings");
  const std::string to_cable =
      "sudo ip route replace 224.0.0.0/4 dev ETH  # ETH: a cable's, of `ip -br link`; for good: the same "
      "route "
      "in its settings";
  if (interface->wireless && !stays_on_machine)
    note("wireless",
         "The way to other machines is " + name +
             ", a radio: it does not repeat multicast that is lost, so that blocks are sent again and again.",
         to_cable);
  if (interface->unplugged && !stays_on_machine)
    note("cable", "The way to other machines is " + name + ", in which no cable is.", to_cable);
  if (interface->speed_mbit_s && *interface->speed_mbit_s < kLeastSpeed_mbit_s && !stays_on_machine)
    note("speed",
         format("%s runs at %d Mbit/s only: what it lost comes again slowly.", name.c_str(),
                *interface->speed_mbit_s),
         "ethtool " + name + "  # says what cable and switch have agreed on; another cable gives 1000");
  if (!findings.empty()) return findings;
  std::string sentence = "The bus goes over " + name;
  if (interface->speed_mbit_s) sentence += format(" at %d Mbit/s", *interface->speed_mbit_s);
  return {{kName, Finding::kWell, sentence + ".", ""}};
}

std::vector<Finding> examine_way(const std::string& url, const std::filesystem::path& proc,
                                 const std::filesystem::path& sys) {
  std::ifstream table(proc / "net/route");
  const std::string text{std::istreambuf_iterator<char>(table), {}};
  const auto name = multicast_interface(text, bus_address(url).value_or(BusAddress{}).group);
  return way_findings(name ? std::optional(network_interface(*name, sys)) : std::nullopt,
                      stays_on_machine(url));
}

Finding receive_buffer(std::int64_t granted_bytes, const std::filesystem::path& proc) {
  constexpr double kMebibyte = 1 << 20;
  const std::string is =
      format("A socket of the bus holds %.1f MiB", static_cast<double>(granted_bytes) / kMebibyte);
  if (granted_bytes >= kReceiveBufferBytes) return {"receive_buffer", Finding::kWell, is + ".", ""};
  const std::string wanted = std::to_string(kReceiveBufferBytes);
  return {"receive_buffer", Finding::kNote,
          is + ", less than the 4 MiB that let a busy recorder listen without asking for repeats.",
          number_in(proc / "sys/net/core/rmem_max") >= kReceiveBufferBytes
              ? "leave recv_buf_size out of --url and LCM_DEFAULT_URL  # the kernel would give 4 MiB"
              : "echo net.core.rmem_max=" + wanted +
                    " | sudo tee /etc/sysctl.d/60-roadbalance.conf && sudo sysctl --system  # stays; the "
                    "packages -node and -host have it"};
}

}  // namespace roadbalance
