#include "host/web/request_post.hpp"

#include <string>
#include <variant>

#include "host/web/request_json.hpp"

namespace roadbalance {
namespace {

PostAnswer take(std::string_view body, Out<Request>& requests) {
  const auto parsed = parse_request(body);
  if (const auto* fault = std::get_if<std::string>(&parsed)) return {400, *fault + "\n"};
  if (!requests.try_send(std::get<Request>(parsed))) return {503, "Too much is asked at once.\n"};
  return {202, "Asked.\n"};
}

}  // namespace

Post request_post(Out<Request>& requests) {
  return {"/request", true, [&requests](std::string_view body) { return take(body, requests); }};
}

}  // namespace roadbalance
