#pragma once

#include <string>
#include <string_view>

namespace roadbalance {

/// Spreadsheets compute a cell that begins with one of = + - @, tabulator or carriage return.  A foreign text
/// that begins so, behind any number of apostrophes, gets one more in front, which reading takes off again.
/// Source: OWASP, CSV Injection.
inline bool needs_apostrophe(std::string_view text) {
  const auto at = text.find_first_not_of('\'');
  return at != std::string_view::npos &&
         std::string_view("=+-@\t\r").find(text[at]) != std::string_view::npos;
}
inline std::string protected_text(std::string_view text) {
  return (needs_apostrophe(text) ? "'" : "") + std::string(text);
}
inline std::string_view unprotected_text(std::string_view text) {
  return text.starts_with('\'') && needs_apostrophe(text) ? text.substr(1) : text;
}

/// Quoted if it must be (RFC 4180).
inline std::string quoted_if_needed(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}
/// A foreign name as a cell.
inline std::string name_cell(std::string_view name) {
  return quoted_if_needed(protected_text(name));
}

}  // namespace roadbalance
