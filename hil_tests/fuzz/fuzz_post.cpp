#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "common/bus/operation.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "host/web/guard.hpp"
#include "host/web/request_json.hpp"

// Posts of strangers to the page's server: bodies of POST /request, and heads of any request.

namespace roadbalance {
namespace {

using fuzz::require;

fuzz::Reached requests("a request"), changes("a change that is admitted");

nlohmann::json said_again(const Request& request) {
  return {{"asker", request.asker}, {"request", request.request}, {"operation", name_of(request.operation)},
          {"node", request.node},   {"channel", request.channel}, {"value", request.value},
          {"text", request.text}};
}

void check_request(std::string_view body) {
  const auto parsed = parse_request(body);
  if (const auto* fault = std::get_if<std::string>(&parsed)) {
    require(!fault->empty() && fault->size() <= 200, "a refusal is a sentence");
    require(std::ranges::all_of(*fault, [](char c) { return c >= 0x20 && c < 0x7F; }),
            "a refusal repeats nothing that a terminal or a page would obey");
    return;
  }
  requests.count();
  const auto& request = std::get<Request>(parsed);
  require(!name_of(request.operation).empty(), "only what has a name is asked");
  const auto heard = decode_request(encode(request));
  require(heard.has_value() && *heard == request, "what is asked on the bus is what was posted");
  const auto again = parse_request(said_again(request).dump());
  require(std::holds_alternative<Request>(again) && std::get<Request>(again) == request,
          "said in another way it is the same request");
}

/// The next line, without its end.
std::string_view line(std::string_view& text) {
  const auto end = std::min(text.find('\n'), text.size());
  const std::string_view taken = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return taken;
}

void check_head(std::string_view text) {
  const OwnAddress here{"127.0.0.1", 8080};
  const GuardRules rules{{"localhost"}, "correct-horse-battery", text.size() % 2 == 0};
  const bool asks_for_feed = text.size() % 3 == 0;
  const std::array lines{line(text), line(text), line(text), line(text), line(text)};
  const auto& [method, target, host, origin, protocols] = lines;
  const std::string_view token = token_of_protocols(protocols);
  require(token.size() <= protocols.size(), "a token is a part of what was said");
  require(viewer_of_protocols(protocols) >= 0, "a page's number is none or positive");
  const bool is_websocket =
      asks_for_feed && method == "GET";  // with another method it is none (RFC 6455, 4.1)
  const RequestHead head{.method = method,
                         .target = target,
                         .host = host,
                         .origin = origin,
                         .token = token,
                         .is_websocket = is_websocket};
  if (admit(head, here, rules) != Admission::kAdmitted) return;
  require(host == "127.0.0.1:8080" || host == "localhost:8080", "only who means us is served");
  const std::string own = "http://" + std::string(host);
  if (method == "GET" || method == "HEAD") {
    require(!is_websocket || origin == own, "the feed is for our own page");
    return;
  }
  require(method == "POST", "there are three methods");
  changes.count();
  require(origin == own && token == rules.token, "a change needs our page and the session's token");
}

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  roadbalance::check_request(text);
  roadbalance::check_head(text);
  return 0;
}
