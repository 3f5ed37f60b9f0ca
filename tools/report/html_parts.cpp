#include "tools/report/html_parts.hpp"

#include <algorithm>
#include <cctype>

#include "common/text/format.hpp"
#include "common/text/markup.hpp"

namespace roadbalance {
namespace {

// About half a page: what is longer may go on over the next.
constexpr std::size_t kWholeRows = 30;

/// A word that no column can hold is cut somewhere, no other.
bool has_long_word(const std::string& text) {
  constexpr std::size_t kLong = 24;
  std::size_t length = 0;
  for (const char c : text) {
    length = c == ' ' ? 0 : length + 1;
    if (length > kLong) return true;
  }
  return false;
}

std::string row(const char* cell, const std::vector<std::string>& texts) {
  std::string cells;
  for (const std::string& text : texts)
    cells += element(cell, markup_text(text), has_long_word(text) ? "long" : "");
  return element("tr", cells);
}

}  // namespace

std::string element(const char* name, const std::string& inside, const char* css_class) {
  const std::string attribute = *css_class == '\0' ? "" : format(" class=\"%s\"", css_class);
  return std::string("<") + name + attribute + ">" + inside + "</" + name + ">\n";
}

std::string paragraph(const std::string& text) {
  return element("p", markup_text(text));
}

std::string words(std::string name) {
  std::ranges::replace(name, '_', ' ');
  return name;
}

std::string sentence(std::string text) {
  if (text.empty()) return text;
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text + ".";
}

std::string table(const std::vector<std::string>& heads, const std::vector<std::vector<std::string>>& rows,
                  std::size_t most) {
  std::string body;
  for (std::size_t k = 0; k < std::min(rows.size(), most); ++k) body += row("td", rows[k]);
  std::string html = element("table", element("thead", row("th", heads)) + element("tbody", body),
                             rows.size() <= kWholeRows ? "whole" : "");
  if (rows.size() > most) html += element("p", format("%zu more are left out here.", rows.size() - most));
  return html;
}

std::string figure(const nlohmann::ordered_json& value, const char* pattern, double factor) {
  return value.is_null() ? "–" : format(pattern, factor * value.get<double>());
}

std::string with_reach(const nlohmann::ordered_json& value, const nlohmann::ordered_json& reach,
                       const char* pattern, double factor) {
  return figure(value, pattern, factor) +
         (value.is_null() || reach.is_null() ? "" : " ± " + figure(reach, pattern, factor));
}

}  // namespace roadbalance
