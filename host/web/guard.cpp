#include "host/web/guard.hpp"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <system_error>

namespace roadbalance {
namespace {

// Browsers omit the default port.
std::string authority(const std::string& name, std::uint16_t port) {
  return port == 80 ? name : name + ":" + std::to_string(port);
}

bool is_ours(std::string_view origin, std::string_view host) {
  constexpr std::string_view kScheme = "http://";
  return origin.starts_with(kScheme) && origin.substr(kScheme.size()) == host;
}

/// The text behind `mark` in the first protocol that begins with it; empty: there is none.
std::string_view after(std::string_view mark, std::string_view protocols) {
  while (!protocols.empty()) {
    const std::size_t comma = protocols.find(',');
    std::string_view protocol = protocols.substr(0, comma);
    protocols = comma == std::string_view::npos ? "" : protocols.substr(comma + 1);
    while (protocol.starts_with(' ')) protocol.remove_prefix(1);
    while (protocol.ends_with(' ')) protocol.remove_suffix(1);
    if (protocol.starts_with(mark)) return protocol.substr(mark.size());
  }
  return {};
}

}  // namespace

Admission admit(const RequestHead& request, const OwnAddress& here, const GuardRules& rules) {
  const auto is_here = [&](const std::string& name) { return request.host == authority(name, here.port); };
  if (!is_here(here.name) && std::ranges::none_of(rules.host, is_here)) return Admission::kHostUnknown;
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (!reads && request.method != "POST") return Admission::kMethodUnknown;
  const bool must_show_origin = request.is_websocket || !reads;
  if ((must_show_origin || !request.origin.empty()) && !is_ours(request.origin, request.host))
    return Admission::kForeignOrigin;
  const bool watches = request.is_websocket || request.only_watches;
  const bool needs_token = watches ? rules.token_to_watch : !reads;
  if (needs_token && (rules.token.size() < kLeastToken || !same_secret(request.token, rules.token)))
    return Admission::kNoToken;
  return Admission::kAdmitted;
}

bool same_secret(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0U : 1U;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

std::string new_token() {
  std::array<unsigned char, 16> random{};
  if (getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size()))
    throw std::system_error(errno, std::generic_category(), "getrandom");
  std::string token;
  for (const unsigned char byte : random)
    for (const int digit : {byte >> 4, byte & 15}) token += "0123456789abcdef"[digit];
  return token;
}

std::string_view token_of_protocols(std::string_view protocols) {
  return after("token.", protocols);
}

std::int64_t viewer_of_protocols(std::string_view protocols) {
  const std::string_view digits = after("viewer.", protocols);
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  const bool is_number = error == std::errc() && end == digits.data() + digits.size();
  return is_number ? std::max<std::int64_t>(number, 0) : 0;
}

}  // namespace roadbalance
