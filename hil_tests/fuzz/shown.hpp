#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/bus/wire_text.hpp"
#include "hil_tests/fuzz/in_form.hpp"
#include "hil_tests/fuzz/property.hpp"

namespace roadbalance::fuzz {

/// A message as a display shows it.
struct Shown {
  std::vector<std::string> lines;
  nlohmann::ordered_json json;
};

/// Nothing that a terminal would obey, and JSON that can be written: dump() throws for what is no UTF-8.
inline void require_plain(const Shown& shown) {
  for (const std::string& line : shown.lines)
    require(wire_text::is_plain_text(line), "what is shown is plain text");
  require(!shown.json.dump().empty(), "what is shown is JSON, too");
}

/// Shows a message that `decode` takes from the bytes as they came, or with size, fingerprint and CRC of a
/// Message.
template <typename Message, typename Decode, typename Show>
void check_shown(std::span<const std::uint8_t> bytes, Decode decode, Show show) {
  if (const auto message = decode(bytes)) require_plain(show(*message));
  const std::vector<std::uint8_t> formed = in_form(encode(Message{}), bytes);
  if (const auto message = decode(std::span<const std::uint8_t>(formed))) require_plain(show(*message));
}

}  // namespace roadbalance::fuzz
