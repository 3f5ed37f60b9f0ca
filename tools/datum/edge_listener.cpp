#include "tools/datum/edge_listener.hpp"

#include <span>
#include <string_view>

#include "common/bus/codec.hpp"

namespace roadbalance {

EdgeListener::EdgeListener(const std::string& url, std::int32_t node, int of_line)
    : line(node, of_line), bus_(url) {
  const auto hear = [this](std::string_view, std::span<const std::uint8_t> bytes) {
    if (accept(bytes, *block_) == Refusal::kNone) line.take(*block_);
  };
  bus_.subscribe("RB_BLOCK_" + std::to_string(node) + "_.*", hear);
  bus_.subscribe(preview_channel(node), hear);
}

}  // namespace roadbalance
