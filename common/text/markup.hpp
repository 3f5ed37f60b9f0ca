#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "common/text/printable.hpp"

namespace roadbalance {

/// `text` for an element or an attribute in double quotes of HTML, SVG or XML: characters with a meaning
/// there are escaped; hidden ones, of which XML forbids some, are shown ("\x1B"), but tabulator and new line,
/// which are blanks there.  Source: Extensible Markup Language 1.0, 5th ed., 2.2 and 2.4.
inline std::string markup_text(std::string_view text) {
  std::string escaped;
  for (std::size_t k = 0; k < text.size();) {
    const char c = text[k];
    const HiddenCharacter hidden = c == '\n' || c == '\t' ? HiddenCharacter{} : hidden_character(text, k);
    if (hidden.bytes > 0)
      escaped += shown(hidden);
    else if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c;
    k += hidden.bytes > 0 ? hidden.bytes : 1;
  }
  return escaped;
}

}  // namespace roadbalance
