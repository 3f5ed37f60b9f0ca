#include "common/bus/bus_route.hpp"

#include <arpa/inet.h>

#include <charconv>
#include <string_view>

#include "common/clock/clock_socket.hpp"

namespace roadbalance {
namespace {

template <typename Number>
bool read_number(std::string_view text, Number& into) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), into);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

std::optional<BusAddress> bus_address(const std::string& url) {
  constexpr std::string_view kScheme = "udpm://", kReceiveBuffer = "recv_buf_size=", kTtl = "ttl=";
  if (!url.starts_with(kScheme)) return std::nullopt;
  const std::string_view rest = std::string_view(url).substr(kScheme.size());
  const std::string_view place = rest.substr(0, rest.find('?'));
  std::string_view options = rest.substr(place.size());
  BusAddress bus;
  const std::string group(place.substr(0, place.find(':')));
  if (!group.empty()) {
    in_addr address{};
    if (inet_pton(AF_INET, group.c_str(), &address) != 1) return std::nullopt;
    bus.group = ntohl(address.s_addr);
  }
  if (place.size() > group.size() && !read_number(place.substr(group.size() + 1), bus.port))
    return std::nullopt;
  while (!options.empty()) {
    options.remove_prefix(1);  // '?' or '&'
    const std::string_view one = options.substr(0, options.find('&'));
    if (one.starts_with(kReceiveBuffer) &&
        !read_number(one.substr(kReceiveBuffer.size()), bus.receive_buffer))
      return std::nullopt;
    if (one.starts_with(kTtl) &&
        (!read_number(one.substr(kTtl.size()), bus.ttl) || bus.ttl < 0 || bus.ttl > 255))
      return std::nullopt;
    options.remove_prefix(one.size());
  }
  return bus;
}

std::uint32_t address_on_bus(const std::string& url) {
  const auto bus = bus_address(url);
  return bus ? address_towards({bus->group, bus->port}).address : 0;
}

}  // namespace roadbalance
