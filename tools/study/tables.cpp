#include <algorithm>
#include <cstdio>
#include <map>

#include "tools/study/study.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

std::string cell(const Json& value) {
  if (value.is_null()) return "-";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value.get<double>());
    return text;
  }
  return value.dump();
}

/// Columns on a terminal: a degree sign is one of them.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t columns, bool to_the_left) {
  const std::string space(columns > width(text) ? columns - width(text) : 0, ' ');
  return to_the_left ? text + space : space + text;
}

/// Keys of all rows, in the order in which they first occur.
std::vector<std::string> columns_of(const Json& table) {
  std::vector<std::string> columns;
  for (const Json& row : table["rows"])
    for (const auto& entry : row.items())
      if (std::find(columns.begin(), columns.end(), entry.key()) == columns.end())
        columns.push_back(entry.key());
  return columns;
}

std::string cell_in(const Json& row, const std::string& column) {
  return row.contains(column) ? cell(row[column]) : "";
}

std::string plain(const Json& table) {
  std::map<std::string, std::size_t> widths;
  const auto columns = columns_of(table);
  for (const std::string& column : columns) {
    widths[column] = width(column);
    for (const Json& row : table["rows"])
      widths[column] = std::max(widths[column], width(cell_in(row, column)));
  }
  std::string text = table["title"].get<std::string>() + "\n";
  const auto line = [&](const auto& value) {
    for (const std::string& column : columns)
      text += padded(value(column), widths[column], column == columns.front()) + "  ";
    text += "\n";
  };
  line([](const std::string& column) { return column; });
  for (const Json& row : table["rows"]) line([&](const std::string& column) { return cell_in(row, column); });
  return text + "\n";
}

std::string markdown(const Json& table) {
  const auto columns = columns_of(table);
  std::string text = "**" + table["title"].get<std::string>() + "**\n\n|", rule = "|";
  for (const std::string& column : columns) {
    text += " " + column + " |";
    rule += column == columns.front() ? " --- |" : " ---: |";
  }
  text += "\n" + rule + "\n";
  for (const Json& row : table["rows"]) {
    text += "|";
    for (const std::string& column : columns) text += " " + cell_in(row, column) + " |";
    text += "\n";
  }
  return text + "\n";
}

/// null: the answers are too few for the line to fail.
const char* verdict(const Json& line) {
  return !line["met"].is_boolean() ? "not judged" : line["met"].get<bool>() ? "met" : "NOT MET";
}

std::string required(const Json& line) {
  return cell(line["required"][0]) + " .. " + cell(line["required"][1]);
}

}  // namespace

std::string plain_tables(const Json& summary) {
  std::string text;
  for (const Json& table : summary.value("tables", Json::array())) text += plain(table);
  return text;
}

std::string plain_acceptance(const Json& summary) {
  if (!summary.contains("acceptance")) return "";
  if (summary["acceptance"].empty()) return "NOT MET     nothing was judged\n";
  std::string text;
  for (const Json& line : summary["acceptance"]) {
    text += padded(verdict(line), 10, true) + "  " + padded(cell(line["line"]), 72, true) + " " +
            padded(cell(line["value"]), 8, false);
    if (line.contains("standard_error")) text += " +- " + cell(line["standard_error"]);
    text += "  (" + required(line) + ")";
    if (line.contains("answers")) text += "  n = " + cell(line["answers"]);
    text += "\n";
  }
  return text;
}

std::string markdown_tables(const Json& summary) {
  std::string text;
  for (const Json& table : summary.value("tables", Json::array())) text += markdown(table);
  if (!summary.contains("acceptance")) return text;
  if (summary["acceptance"].empty()) return text + "NOT MET: nothing was judged\n";
  text += "| acceptance | value | required | answers | |\n| --- | ---: | ---: | ---: | --- |\n";
  for (const Json& line : summary["acceptance"])
    text += "| " + cell(line["line"]) + " | " + cell(line["value"]) + " | " + required(line) + " | " +
            (line.contains("answers") ? cell(line["answers"]) : "") + " | " + verdict(line) + " |\n";
  return text;
}

}  // namespace roadbalance
