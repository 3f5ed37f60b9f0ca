#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// Text for people in a message: a field of fixed extent and how many of its bytes count.  For use inside
/// common/bus only.
namespace roadbalance::wire_text {

/// UTF-8 as Unicode has it (no surrogates, nothing longer than it must be), without control characters.
bool is_plain_text(std::string_view text);

/// As much of the text as fits, cut between characters.
std::string_view cut_to(std::string_view text, std::size_t bytes);

/// The text with ? for what is no UTF-8 and spaces for control characters: it may quote a file or a name.
std::string plain_text(std::string_view text);

/// @param said  made plain and cut: whatever is said arrives
template <typename Byte, std::size_t kBytes>
void put_text(std::string_view said, Byte (&field)[kBytes], std::int32_t& size) {
  const std::string plain = plain_text(said);
  const std::string_view text = cut_to(plain, kBytes);
  for (std::size_t k = 0; k < text.size(); ++k) field[k] = static_cast<Byte>(text[k]);
  size = static_cast<std::int32_t>(text.size());
}

/// Into a field whose text ends where zeros begin.
template <typename Byte, std::size_t kBytes>
void put_text(std::string_view text, Byte (&field)[kBytes]) {
  std::int32_t size = 0;
  put_text(text, field, size);
  std::fill(field + size, field + kBytes, Byte{0});
}

/// Made plain: who sends something else is shown, and harms nobody.
template <typename Byte, std::size_t kBytes>
std::string text_until_zero(const Byte (&field)[kBytes]) {
  return plain_text(std::string(field, std::find(field, field + kBytes, Byte{0})));
}

/// Nothing if the size cannot be or it is no plain text.
template <typename Byte, std::size_t kBytes>
std::optional<std::string> text_of(const Byte (&field)[kBytes], std::int32_t size) {
  if (size < 0 || size > static_cast<std::int32_t>(kBytes)) return std::nullopt;
  std::string text(field, field + size);
  if (!is_plain_text(text)) return std::nullopt;
  return text;
}

}  // namespace roadbalance::wire_text
