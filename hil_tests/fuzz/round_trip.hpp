#pragma once

#include <cxxabi.h>

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <typeinfo>
#include <vector>

#include "hil_tests/fuzz/in_form.hpp"
#include "hil_tests/fuzz/property.hpp"

namespace roadbalance::fuzz {

/// A message that `decode` takes encodes to one that it takes again, as the same bytes; nothing is accepted
/// beyond the one size.
/// @return whether it was taken
template <typename Decode>
bool check_round_trip(std::span<const std::uint8_t> bytes, Decode decode) {
  const auto message = decode(bytes);
  if (!message) return false;
  const std::vector<std::uint8_t> once = encode(*message);
  require(once.size() == bytes.size(), "every message of a type has one size");
  const auto again = decode(std::span<const std::uint8_t>(once));
  require(again.has_value(), "what was accepted is accepted again");
  require(encode(*again) == once, "encoding what was decoded gives the same bytes");
  return true;
}

/// As it is written in the code.
inline std::string name_of(const std::type_info& type) {
  const std::unique_ptr<char, decltype(&std::free)> name(
      abi::__cxa_demangle(type.name(), nullptr, nullptr, nullptr), &std::free);
  return name ? name.get() : type.name();
}

/// The bytes as they came, and with size, fingerprint and CRC of a Message.
template <typename Message, typename Decode>
void check_message(std::span<const std::uint8_t> bytes, Decode decode) {
  static const std::string name = name_of(typeid(Message));
  static Reached messages(name.c_str());
  check_round_trip(bytes, decode);
  const std::vector<std::uint8_t> form = encode(Message{});
  const std::vector<std::uint8_t> formed = in_form(form, bytes);
  if (check_round_trip(formed, decode) && formed != form) messages.count();
}

}  // namespace roadbalance::fuzz
