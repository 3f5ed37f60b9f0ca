#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "common/text/format.hpp"

namespace roadbalance {

/// A character that nobody sees, or that changes how those beside it are shown.
struct HiddenCharacter {
  std::size_t bytes = 0;  ///< of it in UTF-8; 0: the character can be seen
  char32_t code = 0;
};

/// Control characters (C0, DEL, C1), separators of lines, and what has no glyph of its own: bidirectional
/// controls, characters without width, selectors of variants, tags.  Tabulator and new line are among them: a
/// name that has one adds a line to what is printed.  Sources: ECMA-48, 5th ed.; Unicode 15,
/// DerivedCoreProperties.txt, Default_Ignorable_Code_Point, and section 23.8 (annotations between lines).
inline HiddenCharacter hidden_character(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t k) -> char32_t {
    return at + k < text.size() ? static_cast<unsigned char>(text[at + k]) : 0U;
  };
  const char32_t first = byte(0);
  if (first < 0x80) return first < 0x20 || first == 0x7F ? HiddenCharacter{1, first} : HiddenCharacter{};
  const auto is_next = [](char32_t one) { return (one & 0xC0) == 0x80; };
  HiddenCharacter found;
  if ((first & 0xE0) == 0xC0 && is_next(byte(1)))
    found = {2, (first & 0x1F) << 6 | (byte(1) & 0x3F)};
  else if ((first & 0xF0) == 0xE0 && is_next(byte(1)) && is_next(byte(2)))
    found = {3, (first & 0x0F) << 12 | (byte(1) & 0x3F) << 6 | (byte(2) & 0x3F)};
  else if ((first & 0xF8) == 0xF0 && is_next(byte(1)) && is_next(byte(2)) && is_next(byte(3)))
    found = {4, (first & 0x07) << 18 | (byte(1) & 0x3F) << 12 | (byte(2) & 0x3F) << 6 | (byte(3) & 0x3F)};
  constexpr std::array<std::pair<char32_t, char32_t>, 18> kHidden{{{0x80, 0x9F},
                                                                   {0xAD, 0xAD},
                                                                   {0x34F, 0x34F},
                                                                   {0x61C, 0x61C},
                                                                   {0x115F, 0x1160},
                                                                   {0x17B4, 0x17B5},
                                                                   {0x180B, 0x180F},
                                                                   {0x200B, 0x200F},
                                                                   {0x2028, 0x202E},
                                                                   {0x2060, 0x206F},
                                                                   {0x3164, 0x3164},
                                                                   {0xFE00, 0xFE0F},
                                                                   {0xFEFF, 0xFEFF},
                                                                   {0xFFA0, 0xFFA0},
                                                                   {0xFFF0, 0xFFFB},
                                                                   {0x1BCA0, 0x1BCA3},
                                                                   {0x1D173, 0x1D17A},
                                                                   {0xE0000, 0xE0FFF}}};
  const bool hidden = std::ranges::any_of(
      kHidden, [&](const auto& range) { return found.code >= range.first && found.code <= range.second; });
  return hidden ? found : HiddenCharacter{};
}

/// "\x1B", "\u202E", "\U000E0041"
inline std::string shown(HiddenCharacter hidden) {
  const char* const form = hidden.code < 0x100 ? "\\x%02X" : hidden.code < 0x10000 ? "\\u%04X" : "\\U%08X";
  return format(form, static_cast<unsigned>(hidden.code));
}

/// The first hidden character of a text, as shown(); empty: there is none.
inline std::string first_hidden(std::string_view text) {
  for (std::size_t k = 0; k < text.size(); ++k)
    if (const HiddenCharacter hidden = hidden_character(text, k); hidden.bytes > 0) return shown(hidden);
  return "";
}

/// `text` as a terminal may be given it: names and marks are foreign, and hidden characters are shown.
inline std::string printable_text(std::string_view text) {
  std::string printable;
  for (std::size_t k = 0; k < text.size();) {
    const HiddenCharacter hidden = hidden_character(text, k);
    printable += hidden.bytes > 0 ? shown(hidden) : std::string(1, text[k]);
    k += std::max<std::size_t>(1, hidden.bytes);
  }
  return printable;
}

}  // namespace roadbalance
