#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace roadbalance {

/// What pages of a report are made of.

/// <name class="css_class">inside</name>; `inside` is markup.
std::string element(const char* name, const std::string& inside, const char* css_class = "");

/// "front_left": "front left"
std::string words(std::string name);

/// With a capital and a full stop.
std::string sentence(std::string text);

/// A table of plain text, which is escaped.  No row is cut by the end of a page; a table that fits on one is
/// not cut at all, in a longer one each page repeats the heads.
/// @param most  rows that are told; a last row tells how many more there are
std::string table(const std::vector<std::string>& heads, const std::vector<std::vector<std::string>>& rows,
                  std::size_t most = 200);

/// As printf tells it, times a factor; a dash for null.
std::string figure(const nlohmann::ordered_json& value, const char* pattern, double factor = 1.0);
/// "value ± reach"; the reach left out if it is null.
std::string with_reach(const nlohmann::ordered_json& value, const nlohmann::ordered_json& reach,
                       const char* pattern, double factor = 1.0);

}  // namespace roadbalance
