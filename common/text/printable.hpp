#pragma once

#include <string>
#include <string_view>

#include "common/text/format.hpp"

namespace roadbalance {

/// `text` as a terminal may be given it: names and marks are somebody else's, and what commands a terminal in
/// them (C0 but tabulator and new line, DEL, C1 in UTF-8) is shown as \xNN.  Source: ECMA-48, 5th ed.
inline std::string printable_text(std::string_view text) {
  std::string shown;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const auto byte = static_cast<unsigned char>(text[k]);
    const auto next = k + 1 < text.size() ? static_cast<unsigned char>(text[k + 1]) : 0U;
    const bool is_c1 = byte == 0xC2 && next >= 0x80 && next < 0xA0;
    if ((byte < 0x20 && byte != '\n' && byte != '\t') || byte == 0x7F)
      shown += format("\\x%02X", static_cast<unsigned>(byte));
    else if (is_c1)
      shown += format("\\x%02X", static_cast<unsigned>(text[++k] & 0xFF));
    else
      shown += text[k];
  }
  return shown;
}

}  // namespace roadbalance
