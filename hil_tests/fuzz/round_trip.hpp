#pragma once

#include <cstdint>
#include <span>
#include <typeinfo>
#include <vector>

#include "hil_tests/fuzz/in_form.hpp"
#include "hil_tests/fuzz/property.hpp"

namespace roadbalance::fuzz {

/// What `decode` takes encodes to a message that it takes again, as the same bytes; nothing is accepted
/// beyond the one size.
template <typename Message, typename Decode>
void check_round_trip(std::span<const std::uint8_t> bytes, Decode decode) {
  static Reached messages(typeid(Message).name());
  const auto message = decode(bytes);
  if (!message) return;
  messages.count();
  const std::vector<std::uint8_t> once = encode(*message);
  require(once.size() == bytes.size(), "every message of a type has one size");
  const auto again = decode(std::span<const std::uint8_t>(once));
  require(again.has_value(), "what was accepted is accepted again");
  require(encode(*again) == once, "encoding what was decoded gives the same bytes");
}

/// The bytes as they came, and with size, fingerprint and CRC of a Message.
template <typename Message, typename Decode>
void check_message(std::span<const std::uint8_t> bytes, Decode decode) {
  check_round_trip<Message>(bytes, decode);
  check_round_trip<Message>(in_form(encode(Message{}), bytes), decode);
}

}  // namespace roadbalance::fuzz
