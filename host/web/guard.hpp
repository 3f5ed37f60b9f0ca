#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace roadbalance {

/// Who may speak to the server.  Browsers visit strangers' pages too, and those may send requests here: to be
/// admitted a request must come from our own page.  No sockets, no HTTP library.

/// What of a request decides.
struct RequestHead {
  std::string_view method{};  ///< as it came: "GET"
  std::string_view target{};  ///< "/feed"
  std::string_view host{};    ///< empty: none, or several
  std::string_view origin{};  ///< empty: none
  std::string_view token{};   ///< empty: none
  bool is_websocket = false;  ///< asks to become one
  bool only_watches = false;  ///< it changes what is shown to it, and nothing else
};

struct GuardRules {
  /// What Host may name beside the address itself, e.g. "localhost".  Whoever lets his name's address be
  /// changed to ours (DNS rebinding) does not get here.
  std::vector<std::string> host;
  std::string token;           ///< of this session, at least kLeastToken characters
  bool token_to_watch = true;  ///< false: needed for changes of state only
};
inline constexpr std::size_t kLeastToken = 16;

enum class Admission : std::uint16_t {
  kAdmitted = 200,
  kNoToken = 401,        ///< it lacks the session's token
  kForeignOrigin = 403,  ///< a page of somebody else's asks, or nobody knows which
  kMethodUnknown = 405,
  kHostUnknown = 421,  ///< it was meant for another
};

/// Where a request came to: "127.0.0.1", "[::1]".
struct OwnAddress {
  std::string name;
  std::uint16_t port;
};
Admission admit(const RequestHead& request, const OwnAddress& here, const GuardRules& rules);

/// Takes as long whether or not they differ early.
bool same_secret(std::string_view a, std::string_view b);

/// 32 hexadecimal digits nobody can guess.
std::string new_token();

/// The page asks for "roadbalance", "token.<token>" and "viewer.<number>" as WebSocket protocols: a browser
/// lets it say nothing else.  The token of Sec-WebSocket-Protocol; empty: none.
std::string_view token_of_protocols(std::string_view protocols);
/// The number of "viewer.<number>" among them, by which the page calls itself in its View; 0: none.
std::int64_t viewer_of_protocols(std::string_view protocols);
inline constexpr const char* kFeedProtocol = "roadbalance";

}  // namespace roadbalance
