#include "tools/rb/csv_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <string_view>

#include "common/bus/notes.hpp"
#include "common/config/section.hpp"
#include "common/config/text_file.hpp"
#include "host/exchange/pulses.hpp"
#include "host/exchange/units.hpp"

namespace roadbalance {

namespace {

/// The lines of a file, split at commas, without blanks around cells.
class CsvLines {
 public:
  explicit CsvLines(const std::filesystem::path& file)
      : file_(file.string()), stream_(read_text_file(file_)) {}

  bool next() {
    do {
      if (!std::getline(stream_, line_)) return false;
      ++number_;
    } while (trimmed(line_).empty());
    cells_.clear();
    for (std::size_t begin = 0; begin <= line_.size();) {
      const std::size_t end = std::min(line_.find(',', begin), line_.size());
      cells_.push_back(trimmed(std::string_view(line_).substr(begin, end - begin)));
      begin = end + 1;
    }
    return true;
  }
  const std::vector<std::string_view>& cells() const { return cells_; }

  /// As number(), but an empty cell is no number (NaN): there was no sample.
  double sample(std::size_t column, const std::string& name) const {
    return cells_[column].empty() ? std::numeric_limits<double>::quiet_NaN() : number(column, name);
  }
  /// All behind the first two commas: a cell in quotes, which may hold commas and doubled quotes, or a plain
  /// one.
  std::string text_behind_two(const std::string& name) const {
    const std::size_t begin = line_.find(',', line_.find(',') + 1) + 1;
    std::string_view cell = std::string_view(line_).substr(begin);
    if (cell.ends_with('\r')) cell.remove_suffix(1);
    if (!cell.starts_with('"')) return std::string(cell);
    std::string text;
    std::size_t at = 1;
    for (; at < cell.size() && (cell[at] != '"' || cell.substr(at).starts_with("\"\"")); ++at) {
      text += cell[at];
      if (cell[at] == '"') ++at;
    }
    if (at + 1 != cell.size())
      fail(name, "does not end with its quote; allowed: \"...\", quotes in it doubled");
    return text;
  }
  double number(std::size_t column, const std::string& name) const {
    const std::string_view cell = cells_[column];
    double value = 0.0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value))
      fail(name, "\"" + std::string(cell) + "\" is no number; allowed: a finite number with a decimal point");
    return value;
  }
  /// Of the first column; such that nanoseconds of it can be counted.
  double time_s() const {
    constexpr double kMost_s = 1e9;
    const double seconds = number(0, "time_s");
    if (std::abs(seconds) > kMost_s)
      fail("time_s", "\"" + std::string(cells_[0]) + "\" is too far off; allowed: -1e9 to 1e9 s");
    return seconds;
  }
  [[noreturn]] void fail(const std::string& column, const std::string& reason) const {
    throw ConfigError(file_ + ":" + std::to_string(number_) + ": " + column + ": " + reason);
  }

 private:
  static std::string_view trimmed(std::string_view text) {
    const auto begin = text.find_first_not_of(" \t\r\"");
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t\r\"") - begin + 1);
  }

  const std::string file_;
  std::istringstream stream_;
  std::string line_;
  std::int64_t number_ = 0;
  std::vector<std::string_view> cells_;
};

double factor_of(const CsvLines& lines, std::string_view unit, const std::string& column) {
  if (is_reference_column(column)) return 1.0;
  const auto factor = factor_of_unit(unit);
  if (!factor) lines.fail(column, "unit \"" + std::string(unit) + "\" is not known; allowed: " + kKnownUnits);
  return *factor;
}

}  // namespace

bool is_reference_column(std::string_view name) {
  for (const std::string_view wheel : kWheelNames)
    if (name.starts_with(wheel)) {
      const std::string_view rest = name.substr(wheel.size());
      return rest == "_angle_sin" || rest == "_angle_cos";
    }
  return false;
}

SampleTable read_samples(const std::filesystem::path& file) {
  CsvLines lines(file);
  SampleTable table;
  if (!lines.next()) lines.fail("header", "the file is empty; allowed: time_s and channel names");
  if (lines.cells()[0] != "time_s")
    lines.fail(std::string(lines.cells()[0]), "is the first column; allowed: time_s");
  table.name.assign(lines.cells().begin() + 1, lines.cells().end());
  if (table.name.empty()) lines.fail("header", "no channel; allowed: time_s and channel names");
  std::set<std::string> seen;
  for (const auto& name : table.name)
    if (!seen.insert(name).second) lines.fail(name, "stands twice");

  const auto check_width = [&] {
    if (lines.cells().size() != table.name.size() + 1)
      lines.fail("row", std::to_string(lines.cells().size()) + " cells; allowed: " +
                            std::to_string(table.name.size() + 1) + " as in the header");
  };
  if (!lines.next()) lines.fail("units", "missing; allowed: a second row with the unit of each column");
  check_width();
  if (lines.cells()[0] != "s")
    lines.fail("time_s", "unit \"" + std::string(lines.cells()[0]) + "\"; allowed: s");
  std::vector<double> factor;
  for (std::size_t c = 0; c < table.name.size(); ++c)
    factor.push_back(factor_of(lines, lines.cells()[c + 1], table.name[c]));

  table.value_si.resize(table.name.size());
  while (lines.next()) {
    check_width();
    const double time_s = lines.time_s();
    if (!table.time_s.empty() && time_s < table.time_s.back())
      lines.fail("time_s", "goes back; allowed: never falling");
    table.time_s.push_back(time_s);
    for (std::size_t c = 0; c < table.name.size(); ++c)
      table.value_si[c].push_back(factor[c] * lines.sample(c + 1, table.name[c]));
  }
  return table;
}

std::vector<Pulse> read_pulses(const std::filesystem::path& file) {
  CsvLines lines(file);
  const std::vector<std::string_view> header{"time_s", "wheel", "kind"};
  if (!lines.next() || lines.cells() != header) lines.fail("header", "allowed: time_s,wheel,kind");
  std::vector<Pulse> pulses;
  while (lines.next()) {
    if (lines.cells().size() != header.size()) lines.fail("row", "allowed: 3 cells");
    const double time_s = lines.time_s();
    if (!pulses.empty() && time_s < pulses.back().time_s)
      lines.fail("time_s", "goes back; allowed: never falling");
    const auto wheel = std::find(kWheelNames.begin(), kWheelNames.end(), lines.cells()[1]);
    if (wheel == kWheelNames.end())
      lines.fail("wheel", "\"" + std::string(lines.cells()[1]) +
                              "\"; allowed: front_left, front_right, rear_left, rear_right");
    const std::string_view kind = lines.cells()[2];
    const auto known = std::find(kPulseKinds.begin(), kPulseKinds.end(), kind);
    if (known == kPulseKinds.end())
      lines.fail("kind", "\"" + std::string(kind) + "\"; allowed: tooth, zero, tooth_backward, lost");
    pulses.push_back({time_s, static_cast<int>(wheel - kWheelNames.begin()),
                      static_cast<EdgeKind>(known - kPulseKinds.begin())});
  }
  return pulses;
}

std::vector<ImportedMark> read_marks(const std::filesystem::path& file) {
  CsvLines lines(file);
  const std::vector<std::string_view> header{"time_s", "number", "text"};
  if (!lines.next() || lines.cells() != header) lines.fail("header", "allowed: time_s,number,text");
  std::vector<ImportedMark> marks;
  std::set<double> numbers;
  while (lines.next()) {
    if (lines.cells().size() < header.size()) lines.fail("row", "allowed: 3 cells");
    const double time_s = lines.time_s();
    if (!marks.empty() && time_s < marks.back().time_s)
      lines.fail("time_s", "goes back; allowed: never falling");
    const double number = lines.number(1, "number");
    if (number < 1.0 || number > 1e9 || number != std::floor(number))
      lines.fail("number", "allowed: a whole number from 1 to 1000000000");
    if (!numbers.insert(number).second) lines.fail("number", "stands above already; allowed: each once");
    std::string text = lines.text_behind_two("text");
    if (text.size() > kMaxNoteBytes)
      lines.fail("text", std::to_string(text.size()) + " bytes; allowed: " + std::to_string(kMaxNoteBytes));
    marks.push_back({time_s, static_cast<std::int64_t>(number), std::move(text)});
  }
  return marks;
}

}  // namespace roadbalance
