#pragma once

#include <string>
#include <string_view>

namespace roadbalance {

/// `text` for an element or an attribute in double quotes of HTML, SVG or XML: characters with a meaning
/// there are escaped; control characters, of which they allow but tabulator and new line, become blanks.
/// Source: Extensible Markup Language 1.0, 5th ed., 2.2 and 2.4.
inline std::string markup_text(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t')
      escaped += ' ';
    else
      escaped += c;
  }
  return escaped;
}

}  // namespace roadbalance
