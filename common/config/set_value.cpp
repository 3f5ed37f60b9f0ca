#include "common/config/set_value.hpp"

#include <algorithm>
#include <cassert>
#include <cstdio>
#include <optional>
#include <utility>

#include "common/config/section.hpp"
#include "common/config/toml_library.hpp"

namespace roadbalance {
namespace {

std::string written(const TablePath& path) {
  std::string text;
  for (const TableStep& step : path)
    text += (text.empty() ? "" : ".") + step.key + (step.name.empty() ? "" : " \"" + step.name + "\"");
  return text.empty() ? "the file" : text;
}

/// The table one step down; nullptr if there is none.
toml::table* step_down(toml::table& from, const TableStep& step) {
  toml::node* const node = from.get(step.key);
  if (!node || step.name.empty()) return node ? node->as_table() : nullptr;
  toml::array* const array = node->as_array();
  if (!array) return nullptr;
  for (toml::node& element : *array) {
    toml::table* const table = element.as_table();
    if (table && (*table)["name"].value<std::string>() == step.name) return table;
  }
  return nullptr;
}

/// Byte of a place that toml++ names by line and by column, which it counts in code points.
std::size_t byte_of(const std::string& text, const toml::source_position& place) {
  std::size_t at = 0;
  for (toml::source_index line = 1; line < place.line; ++line) at = text.find('\n', at) + 1;
  for (toml::source_index column = 1; column < place.column && at < text.size(); ++column)
    while (++at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U) {
    }
  return at;
}

bool stands_in_place(const toml::node& node) {
  if (const toml::table* table = node.as_table()) return table->is_inline();
  const toml::array* const array = node.as_array();
  return !array || array->empty() || !array->is_array_of_tables() ||
         array->get_as<toml::table>(0)->is_inline();
}

/// Where the last of the table's own values ends, and where its key begins.
std::optional<std::pair<std::size_t, std::size_t>> last_value(const std::string& text,
                                                              const toml::table& table) {
  std::optional<std::pair<std::size_t, std::size_t>> last;
  for (const auto& [key, node] : table) {
    if (!stands_in_place(node)) continue;
    const std::pair ends{byte_of(text, node.source().end), byte_of(text, key.source().begin)};
    if (!last || ends > *last) last = ends;
  }
  return last;
}

std::string inserted(std::string text, std::size_t at, const std::string& more) {
  return text.insert(at, more);
}

std::string into_braces(const std::string& text, const toml::table& table, const std::string& entry) {
  if (const auto last = last_value(text, table)) return inserted(text, last->first, ", " + entry);
  const std::size_t begin = byte_of(text, table.source().begin);
  const std::size_t end = byte_of(text, table.source().end);
  return std::string(text).replace(begin, end - begin, "{ " + entry + " }");
}

/// On a line behind the table's last value, or behind its header; indented as that.
std::string on_a_line(const std::string& text, const toml::table& table, bool root,
                      const std::string& entry) {
  const auto last = last_value(text, table);
  if (!last && root) return entry + "\n" + text;
  const std::size_t behind = last ? last->first : byte_of(text, table.source().end);
  const std::size_t key = last ? last->second : byte_of(text, table.source().begin);
  const std::size_t line = key == 0 ? 0 : text.rfind('\n', key - 1) + 1;
  const std::string before = text.substr(line, key - line);
  const std::string indent = before.find_first_not_of(" \t") == std::string::npos ? before : "";
  const std::size_t end = text.find('\n', behind);
  if (end == std::string::npos) return text + "\n" + indent + entry + "\n";
  const std::string line_end = end > 0 && text[end - 1] == '\r' ? "\r\n" : "\n";
  return inserted(text, end + 1, indent + entry + line_end);
}

std::string with_new_key(const std::string& text, const toml::table& table, bool root,
                         const std::string& entry) {
  return table.is_inline() ? into_braces(text, table, entry) : on_a_line(text, table, root, entry);
}

}  // namespace

std::string with_value(const std::string& text, const TablePath& path, const std::string& key,
                       const std::string& value, const std::string& name_for_errors) {
  toml::table root = parse_toml(text, name_for_errors);
  const toml::table wanted = parse_toml("value = " + value, "value");
  const auto fail = [&](const std::string& reason) {
    throw ConfigError(name_for_errors + ": " + written(path) + ": " + key + ": " + reason);
  };
  toml::table* table = &root;
  std::string changed;
  for (std::size_t k = 0; k < path.size() && changed.empty(); ++k) {
    toml::table* const next = step_down(*table, path[k]);
    if (next) {
      table = next;
      continue;
    }
    const TableStep& step = path[k];
    if (k + 1 < path.size() || !step.name.empty() || table->contains(step.key))
      fail("there is no table " + written(TablePath(path.begin(), path.begin() + static_cast<long>(k) + 1)) +
           " to set it in");
    changed = with_new_key(text, *table, table == &root, step.key + " = { " + key + " = " + value + " }");
    table = table->insert(step.key, toml::table{}).first->second.as_table();
  }
  if (const toml::node* there = changed.empty() ? table->get(key) : nullptr) {
    if (!there->is_value()) fail("is no single value and cannot be replaced by one");
    const std::size_t begin = byte_of(text, there->source().begin);
    changed = std::string(text).replace(begin, byte_of(text, there->source().end) - begin, value);
  } else if (changed.empty()) {
    changed = with_new_key(text, *table, table == &root, key + " = " + value);
  }
  table->insert_or_assign(key, *wanted.get("value"));
  // The one proof that it stands where it should and that nothing else moved.
  try {
    if (parse_toml(changed, name_for_errors) == root) return changed;
  } catch (const ConfigError&) {
  }
  fail("the table is written in a form that no program can change; set it to " + value + " by hand");
  return {};
}

std::string toml_number(double value, int decimals) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.*f", decimals, value);
  std::string text = buffer;
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

}  // namespace roadbalance
