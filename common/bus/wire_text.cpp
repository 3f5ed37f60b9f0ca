#include "common/bus/wire_text.hpp"

namespace roadbalance::wire_text {
namespace {

bool continues(unsigned char byte) {
  return (byte & 0xC0) == 0x80;
}

// Bytes of the character that begins the text; 0: it is none.  Unicode 15, table 3-7.
std::size_t character(std::string_view text) {
  const auto at = [&text](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char first = at(0);
  if (first < 0x20 || first == 0x7F) return 0;
  if (first < 0x80) return 1;
  std::size_t bytes = 0;
  if (0xC2 <= first && first <= 0xDF) bytes = 2;
  if (0xE0 <= first && first <= 0xEF) bytes = 3;
  if (0xF0 <= first && first <= 0xF4) bytes = 4;
  if (bytes == 0 || text.size() < bytes) return 0;
  for (std::size_t k = 1; k < bytes; ++k)
    if (!continues(at(k))) return 0;
  const unsigned char second = at(1);
  if (first == 0xC2 && second < 0xA0) return 0;  // C1 control characters
  if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) ||
      (first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F))
    return 0;
  return bytes;
}

}  // namespace

bool is_plain_text(std::string_view text) {
  while (!text.empty()) {
    const std::size_t bytes = character(text);
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

std::string plain_text(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const std::size_t bytes = character(text);
    const auto first = static_cast<unsigned char>(text.front());
    if (bytes > 0)
      plain += text.substr(0, bytes);
    else
      plain += first < 0x20 || first == 0x7F ? ' ' : '?';
    text.remove_prefix(bytes > 0 ? bytes : 1);
  }
  return plain;
}

std::string_view cut_to(std::string_view text, std::size_t bytes) {
  if (text.size() <= bytes) return text;
  while (bytes > 0 && continues(static_cast<unsigned char>(text[bytes]))) --bytes;
  return text.substr(0, bytes);
}

}  // namespace roadbalance::wire_text
