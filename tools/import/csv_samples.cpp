#include "tools/import/csv_samples.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <string_view>

#include "common/bus/notes.hpp"
#include "common/text/printable.hpp"
#include "host/recording/formats/csv_text.hpp"
#include "host/recording/formats/pulses.hpp"

namespace roadbalance {

namespace {

constexpr double kNever_s = -std::numeric_limits<double>::infinity();

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r\"");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r\"") - begin + 1);
}

/// Time of the row that was read last.
double next_time_s(const CsvLines& lines, double last_s) {
  const double time_s = lines.time_s();
  if (time_s < last_s) lines.fail("time_s", "goes back; allowed: never falling");
  return time_s;
}

class CsvSamples final : public SampleSource {
 public:
  explicit CsvSamples(const std::filesystem::path& file) : file_(open_again_and_again(file)), lines_(file_) {
    if (!lines_.next()) lines_.fail("header", "the file is empty; allowed: time_s and channel names");
    if (lines_.cells()[0] != "time_s")
      lines_.fail(std::string(lines_.cells()[0]), "is the first column; allowed: time_s");
    std::set<std::string> seen;
    for (const auto& name : std::span(lines_.cells()).subspan(1)) {
      if (!seen.emplace(name).second) lines_.fail(std::string(name), "stands twice");
      channel_.push_back({.name = std::string(unprotected_text(name))});
    }
    if (channel_.empty()) lines_.fail("header", "no channel; allowed: time_s and channel names");
    if (!lines_.next()) lines_.fail("units", "missing; allowed: a second row with the unit of each column");
    check_width();
    if (lines_.cells()[0] != "s")
      lines_.fail("time_s", "unit \"" + std::string(lines_.cells()[0]) + "\"; allowed: s");
    for (std::size_t c = 0; c < channel_.size(); ++c) channel_[c].unit = lines_.cells()[c + 1];
    first_ = lines_.place();
  }

  const std::vector<FileChannel>& channels() const override { return channel_; }
  double part() const override { return lines_.part(); }
  void rewind() override {
    lines_ = CsvLines(file_, first_);
    last_s_ = kNever_s;
  }
  bool read(SampleRows& rows) override {
    rows.clear();
    rows.channels = channel_.size();
    while (rows.rows() < kRowsAtOnce && lines_.next()) {
      check_width();
      rows.time_s.push_back(last_s_ = next_time_s(lines_, last_s_));
      for (std::size_t c = 0; c < channel_.size(); ++c)
        rows.value.push_back(lines_.sample(c + 1, channel_[c].name));
    }
    return rows.rows() > 0;
  }

 private:
  void check_width() const {
    if (lines_.cells().size() != channel_.size() + 1)
      lines_.fail("row", std::to_string(lines_.cells().size()) +
                             " cells; allowed: " + std::to_string(channel_.size() + 1) + " as in the header");
  }

  const std::shared_ptr<const File> file_;
  CsvLines lines_;
  LinePlace first_;  // row
  std::vector<FileChannel> channel_;
  double last_s_ = kNever_s;
};

}  // namespace

bool is_reference_column(std::string_view name) {
  for (const std::string_view wheel : kWheelNames)
    if (name.starts_with(wheel)) {
      const std::string_view rest = name.substr(wheel.size());
      return rest == "_angle_sin" || rest == "_angle_cos";
    }
  return false;
}

bool CsvLines::next() {
  cells_.clear();
  do {
    if (!lines_.next()) return false;
  } while (trimmed(lines_.line()).empty());
  const std::string_view line = lines_.line();
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells_.push_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return true;
}

double CsvLines::number(std::size_t column, const std::string& name) const {
  const std::string_view cell = cells_[column];
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value))
    fail(name, "\"" + std::string(cell) + "\" is no number; allowed: a finite number with a decimal point");
  return value;
}

double CsvLines::sample(std::size_t column, const std::string& name) const {
  return cells_[column].empty() ? std::numeric_limits<double>::quiet_NaN() : number(column, name);
}

double CsvLines::time_s() const {
  const double seconds = number(0, "time_s");
  if (!is_countable(seconds)) fail("time_s", "\"" + std::string(cells_[0]) + "\" " + kTooFarOff);
  return seconds;
}

std::string CsvLines::text_behind_two(const std::string& name) const {
  const std::string_view line = lines_.line();
  const std::string_view cell = line.substr(line.find(',', line.find(',') + 1) + 1);
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

void CsvLines::fail(const std::string& column, const std::string& reason) const {
  lines_.fail(column + ": " + reason);
}

std::unique_ptr<SampleSource> open_csv_samples(const std::filesystem::path& file) {
  return std::make_unique<CsvSamples>(file);
}

PulseSource::PulseSource(const std::filesystem::path& file)
    : file_(open_again_and_again(file)), lines_(file_), last_s_(kNever_s) {
  const std::vector<std::string_view> header{"time_s", "wheel", "kind"};
  if (!lines_.next() || lines_.cells() != header) lines_.fail("header", "allowed: time_s,wheel,kind");
  first_ = lines_.place();
}

void PulseSource::rewind() {
  lines_ = CsvLines(file_, first_);
  last_s_ = kNever_s;
}

std::optional<Pulse> PulseSource::next() {
  if (!lines_.next()) return std::nullopt;
  if (lines_.cells().size() != 3) lines_.fail("row", "allowed: 3 cells");
  last_s_ = next_time_s(lines_, last_s_);
  const auto wheel = std::find(kWheelNames.begin(), kWheelNames.end(), lines_.cells()[1]);
  if (wheel == kWheelNames.end())
    lines_.fail("wheel", "\"" + std::string(lines_.cells()[1]) +
                             "\"; allowed: front_left, front_right, rear_left, rear_right");
  const std::string_view kind = lines_.cells()[2];
  const auto known = std::find(kPulseKinds.begin(), kPulseKinds.end(), kind);
  if (known == kPulseKinds.end())
    lines_.fail("kind", "\"" + std::string(kind) + "\"; allowed: tooth, zero, tooth_backward, lost");
  return Pulse{last_s_, static_cast<int>(wheel - kWheelNames.begin()),
               static_cast<EdgeKind>(known - kPulseKinds.begin())};
}

std::vector<ImportedMark> read_marks(const std::filesystem::path& file) {
  CsvLines lines(open_again_and_again(file));
  const std::vector<std::string_view> header{"time_s", "number", "text"};
  if (!lines.next() || lines.cells() != header) lines.fail("header", "allowed: time_s,number,text");
  std::vector<ImportedMark> marks;
  std::set<double> numbers;
  while (lines.next()) {
    if (lines.cells().size() < header.size()) lines.fail("row", "allowed: 3 cells");
    const double time_s = next_time_s(lines, marks.empty() ? kNever_s : marks.back().time_s);
    const double number = lines.number(1, "number");
    if (number < 1.0 || number > 1e9 || number != std::floor(number))
      lines.fail("number", "allowed: a whole number from 1 to 1000000000");
    if (!numbers.insert(number).second) lines.fail("number", "stands above already; allowed: each once");
    const std::string cell = lines.text_behind_two("text");
    std::string text(unprotected_text(cell));
    if (const std::string hidden = first_hidden(text); !hidden.empty())
      lines.fail("text", "has the hidden character " + hidden + "; allowed: text that can be seen");
    if (text.size() > kMaxNoteBytes)
      lines.fail("text", std::to_string(text.size()) + " bytes; allowed: " + std::to_string(kMaxNoteBytes));
    marks.push_back({time_s, static_cast<std::int64_t>(number), std::move(text)});
  }
  return marks;
}

}  // namespace roadbalance
