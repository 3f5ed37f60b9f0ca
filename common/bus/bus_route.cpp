#include "common/bus/bus_route.hpp"

#include <arpa/inet.h>

#include <string_view>

#include "common/clock/clock_socket.hpp"

namespace roadbalance {

std::uint32_t address_on_bus(const std::string& url) {
  constexpr std::string_view kScheme = "udpm://";
  if (!url.starts_with(kScheme)) return 0;
  std::string_view rest = std::string_view(url).substr(kScheme.size());
  rest = rest.substr(0, rest.find('?'));
  const std::string group(rest.empty() ? "239.255.76.67" : rest.substr(0, rest.find(':')));
  in_addr address{};
  if (inet_pton(AF_INET, group.c_str(), &address) != 1) return 0;
  return address_towards({ntohl(address.s_addr), 7667}).address;  // any port has the same way
}

}  // namespace roadbalance
