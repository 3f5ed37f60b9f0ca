#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace roadbalance {

/// Parts of the pages of a report.

/// <name class="css_class">inside</name>; `inside` is markup.
std::string element(const char* name, const std::string& inside, const char* css_class = "");

/// A <p> of plain text, which is escaped.
std::string paragraph(const std::string& text);

/// "front_left": "front left"
std::string words(std::string name);

/// With a capital and a full stop.
std::string sentence(std::string text);

/// A table of plain text, which is escaped.  No row is cut by the end of a page; a table that fits on one is
/// not cut at all, in a longer one each page repeats the heads.
/// @param most  rows that are written; a last row counts the others
std::string table(const std::vector<std::string>& heads, const std::vector<std::vector<std::string>>& rows,
                  std::size_t most = 200);

/// The number as printf writes it, times a factor; a dash for null.
std::string figure(const nlohmann::ordered_json& value, const char* pattern, double factor = 1.0);
/// "value ± reach"; the reach left out if it is null.
std::string with_reach(const nlohmann::ordered_json& value, const nlohmann::ordered_json& reach,
                       const char* pattern, double factor = 1.0);

}  // namespace roadbalance
