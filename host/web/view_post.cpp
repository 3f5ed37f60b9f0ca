#include "host/web/view_post.hpp"

#include <cstdint>
#include <span>

#include "common/bus/transfer_report.hpp"

namespace roadbalance {
namespace {

PostAnswer take(std::string_view body, Bus& bus, Feed& feed) {
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(body.data()), body.size());
  const auto view = decode_view(bytes);
  if (!view || view->viewer == 0) return {400, "That is no view of this version: load the page again.\n"};
  if (!feed.expect(view->viewer, WallClock::now()))
    return {503, "Too many pages show plots: close one of them.\n"};
  if (!bus.publish(kViewChannel, bytes)) return {503, "The bus takes nothing at present.\n"};
  return {};
}

}  // namespace

Post view_post(Bus& bus, Feed& feed) {
  return {"/view", false, [&](std::string_view body) { return take(body, bus, feed); }};
}

}  // namespace roadbalance
