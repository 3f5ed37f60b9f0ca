#pragma once

#include <string>
#include <vector>

namespace roadbalance {

/// A way from the top of a TOML text down to one of its tables: {{"wheel", "front_left"}, {"encoder"}} is
/// the table `encoder` of that [[wheel]] whose `name` is "front_left".
struct TableStep {
  std::string key;
  std::string name{};  ///< of [[key]] the one so named; empty: [key] is a table
};
using TablePath = std::vector<TableStep>;

/// The text with `key = value` in one of its tables; every other byte stays as the user wrote it.
///
/// A value that is there is replaced.  One that is not comes on a line of its own behind the table's last, or
/// last between the braces of an inline table; if the table at the end of the path is missing, it is made as
/// an inline table.  The rest of the text must mean the same afterwards: a form in which this is impossible
/// (dotted keys) is refused.
/// @param value  as TOML writes it: 12.5, "a text"
/// @throws ConfigError naming what is not there, or cannot be placed
std::string with_value(const std::string& text, const TablePath& path, const std::string& key,
                       const std::string& value, const std::string& name_for_errors);

/// A number as with_value takes it, rounded to so many decimals: 12.5, -0.25, 30.
std::string toml_number(double value, int decimals);

}  // namespace roadbalance
