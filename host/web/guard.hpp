#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace roadbalance {

/// Decides which requests the server admits.  Browsers also visit foreign pages, which may send requests
/// here: a request must come from our own page.  No sockets, no HTTP library.

/// The parts of a request that decide.
struct RequestHead {
  std::string_view method{};  ///< as it came: "GET"
  std::string_view target{};  ///< "/feed"
  std::string_view host{};    ///< empty: no such header, or several
  std::string_view origin{};  ///< empty: none
  std::string_view token{};   ///< empty: none
  bool is_websocket = false;  ///< it asks for an upgrade
  bool only_watches = false;  ///< it changes only the view of its own page
};

struct GuardRules {
  /// Allowed names in Host beside the address itself, e.g. "localhost".  This stops foreign names whose
  /// address was changed to ours (DNS rebinding).
  std::vector<std::string> host;
  std::string token;           ///< of this session, at least kLeastToken characters
  bool token_to_watch = true;  ///< false: needed for changes of state only
};
inline constexpr std::size_t kLeastToken = 16;

enum class Admission : std::uint16_t {
  kAdmitted = 200,
  kNoToken = 401,        ///< it lacks the session's token
  kForeignOrigin = 403,  ///< a foreign page asks, or an unknown one
  kMethodUnknown = 405,
  kHostUnknown = 421,  ///< it was meant for another server
};

/// The address that a request reached: "127.0.0.1", "[::1]".
struct OwnAddress {
  std::string name;
  std::uint16_t port;
};
Admission admit(const RequestHead& request, const OwnAddress& here, const GuardRules& rules);

/// Compares in a time that does not depend on where they differ.
bool same_secret(std::string_view a, std::string_view b);

/// 32 random hexadecimal digits.
std::string new_token();

/// The token in Sec-WebSocket-Protocol; empty: none.  The page asks for the protocols "roadbalance",
/// "token.<token>" and "viewer.<number>", since a browser lets it send nothing else with a WebSocket.
std::string_view token_of_protocols(std::string_view protocols);
/// The number of "viewer.<number>" among them, the viewer of the page's View; 0: none.
std::int64_t viewer_of_protocols(std::string_view protocols);
inline constexpr const char* kFeedProtocol = "roadbalance";

}  // namespace roadbalance
