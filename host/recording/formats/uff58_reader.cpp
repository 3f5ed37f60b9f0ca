#include "host/recording/formats/uff58_reader.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "common/text/format.hpp"
#include "host/recording/formats/line_reader.hpp"
#include "host/recording/formats/units.hpp"

namespace roadbalance {
namespace {

constexpr std::string_view kMarker = "    -1";
constexpr std::int64_t kMostUffSamples = std::int64_t{1} << 31;
constexpr double kStepDigits = 1e-5;  ///< E13.5 has 6 digits

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

class Lines {
 public:
  explicit Lines(std::shared_ptr<const File> file, LinePlace from = {}) : lines_(std::move(file), from) {}

  bool next() { return lines_.next(); }
  /// @throws ConfigError if the file ends
  void need(const char* what) {
    if (!next()) fail(std::string("the file ends; allowed: ") + what);
  }
  std::string_view line() const { return lines_.line(); }
  bool is_marker() const { return line().substr(0, 6) == kMarker && trimmed(line()) == "-1"; }
  LinePlace place() const { return lines_.place(); }

  [[noreturn]] void fail(const std::string& reason) const { lines_.fail(reason); }

  std::string_view field(std::size_t at, std::size_t width) const {
    return at < line().size() ? trimmed(line().substr(at, width)) : std::string_view();
  }
  std::int64_t integer(std::size_t at, std::size_t width, const char* what) const {
    std::int64_t value = 0;
    const std::string_view text = field(at, width);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      fail(std::string(what) + ": \"" + std::string(text) + "\" in columns " + std::to_string(at + 1) +
           " to " + std::to_string(at + width) + " is no whole number");
    return value;
  }
  /// "NaN" is NaN; Fortran's D stands for E.
  double number(std::size_t at, std::size_t width, const char* what) const {
    std::string text(field(at, width));
    if (text == "NaN") return std::numeric_limits<double>::quiet_NaN();
    std::replace(text.begin(), text.end(), 'D', 'E');
    const std::size_t sign = text.starts_with('+') ? 1 : 0;
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data() + sign, text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
      fail(std::string(what) + ": \"" + text + "\" in columns " + std::to_string(at + 1) + " to " +
           std::to_string(at + width) + " is no number");
    return value;
  }

 private:
  LineReader lines_;
};

/// Even instants, as record 7 gives them.
struct Abscissa {
  std::int64_t samples = 0;
  double first_s = 0.0, step_s = 0.0;

  double time_s(std::int64_t row) const { return first_s + static_cast<double>(row) * step_s; }
  bool operator==(const Abscissa&) const = default;
};

void pass_over(Lines& lines) {
  do lines.need("-1 in columns 5 and 6, which ends a data set");
  while (!lines.is_marker());
}

/// From data set 164: units of length in a metre.
double read_length_factor(Lines& lines) {
  lines.need("units");
  lines.need("conversion factors");
  const double factor = lines.number(0, 25, "length factor");
  if (!(factor > 0.0)) lines.fail("length factor: allowed: above 0");
  pass_over(lines);
  return factor;
}

/// The unit at the end of an axis' label: "Acceleration g", "Acceleration (mm/s^2)"; empty: there is none.
std::string unit_in(std::string_view label) {
  const bool round = label.ends_with(')'), square = label.ends_with(']');
  if (const auto at = label.find_last_of(round ? '(' : square ? '[' : ' '); at != std::string_view::npos)
    label.remove_prefix(at + 1);
  if (round || square) label.remove_suffix(1);
  return unit_named(label) ? std::string(trimmed(label)) : std::string();
}

/// Record 9: the kind of quantity and its unit, and the lengths that hold where it stands.
struct Ordinate {
  std::int64_t type = 0;
  std::string unit = {};
  std::optional<double> length_factor = {};  ///< units of length in a metre; nothing: no data set 164 so far
};

Ordinate ordinate(const Lines& lines, std::optional<double> length_factor) {
  const std::string_view unit = lines.field(47, 20);
  return {.type = lines.integer(0, 10, "ordinate's specific data type"),
          .unit = unit.empty() || unit == "NONE" ? unit_in(lines.field(26, 20)) : std::string(unit),
          .length_factor = length_factor};
}

/// @param factor  units of length in a metre
std::string length_name(double factor) {
  // Files give the factor with as few as five digits.
  const auto is_it = [&](const char* length) {
    return std::abs(factor * unit_named(length)->factor - 1.0) < 1e-4;
  };
  constexpr std::array kLengths{"m", "mm", "cm", "in", "ft"};
  const auto length = std::ranges::find_if(kLengths, is_it);
  return length == kLengths.end() ? "length/" + format("%g", factor) : *length;
}

/// @param any_lengths  the file has a data set 164, if only behind it
FileChannel channel_of(const std::string& name, const Ordinate& ordinate, bool any_lengths) {
  constexpr std::int64_t kUnknown = 0, kGeneral = 1, kDisplacement = 8, kVelocity = 11, kAcceleration = 12;
  FileChannel channel{.name = name, .unit = ordinate.unit};
  if (!ordinate.unit.empty() || ordinate.type == kUnknown || ordinate.type == kGeneral) return channel;
  const char* per = "";
  switch (ordinate.type) {
    case kDisplacement:
      break;
    case kVelocity:
      per = "/s";
      break;
    case kAcceleration:
      per = "/s^2";
      break;
    default:
      channel.unit = "data type " + std::to_string(ordinate.type);
      return channel;
  }
  if (ordinate.length_factor)
    channel.unit = length_name(*ordinate.length_factor) + per;
  else if (any_lengths)
    channel.unit = "of data set 164, which stands behind it";  // whether it holds there, too, is unknown
  else
    channel.quantity = std::string("m") + per;
  return channel;
}

/// The number at the begin of a text.
std::optional<double> leading_number(std::string_view text) {
  double value = 0.0;
  if (std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc()) return std::nullopt;
  return value;
}

/// Rate and begin in a file of rb export, with more digits than record 7: "Rate 2000 Hz, first sample at 1.5
/// s".
void refine(std::string_view id_line, Abscissa& abscissa) {
  constexpr std::string_view kBegin = "Rate ";
  if (!id_line.starts_with(kBegin)) return;
  const auto rate_hz = leading_number(id_line.substr(kBegin.size()));
  if (rate_hz && *rate_hz > 0.0 && std::abs(*rate_hz * abscissa.step_s - 1.0) < kStepDigits)
    abscissa.step_s = 1.0 / *rate_hz;
  constexpr std::string_view kFirst = "first sample at ";
  const auto at = id_line.find(kFirst);
  if (at == std::string_view::npos) return;
  const auto first_s = leading_number(id_line.substr(at + kFirst.size()));
  if (first_s && std::abs(*first_s - abscissa.first_s) <= kStepDigits * std::abs(abscissa.first_s))
    abscissa.first_s = *first_s;
}

/// A time response: the place of its values, and how far they have been read.
class Column {
 public:
  Column(std::shared_ptr<const File> file, std::string name, LinePlace first, std::size_t per_line,
         std::size_t width)
      : file_(std::move(file)),
        name_(std::move(name)),
        first_(first),
        per_line_(per_line),
        width_(width),
        lines_(file_, first) {}

  void rewind() {
    lines_ = Lines(file_, first_);
    next_in_line_ = 0;
  }
  /// The next value; the caller counts them.
  double next() {
    if (next_in_line_ == 0) lines_.need("more values");
    const double value = lines_.number(next_in_line_ * width_, width_, name_.c_str());
    next_in_line_ = (next_in_line_ + 1) % per_line_;
    return value;
  }

 private:
  std::shared_ptr<const File> file_;
  std::string name_;
  LinePlace first_;
  std::size_t per_line_, width_;
  Lines lines_;
  std::size_t next_in_line_ = 0;
};

/// Channels stand one behind the other in the file; each is read at its own place.
class UniversalSamples final : public SampleSource {
 public:
  explicit UniversalSamples(const std::filesystem::path& path)
      : file_(open_again_and_again(path)), lines_(file_) {
    while (lines_.next()) {
      if (trimmed(lines_.line()).empty()) continue;
      if (!lines_.is_marker()) lines_.fail("allowed: -1 in columns 5 and 6, which begins a data set");
      lines_.need("type of the data set");
      if (lines_.line().substr(0, 7) == "    58b") lines_.fail("is binary; allowed: an ASCII universal file");
      switch (lines_.integer(0, 6, "type of the data set")) {
        case 58:
          find_function();
          break;
        case 164:
          length_factor_ = read_length_factor(lines_);
          break;
        default:
          pass_over(lines_);
      }
    }
    if (channel_.empty()) lines_.fail("no time response (data set 58, function type 1)");
    for (std::size_t c = 0; c < channel_.size(); ++c)
      channel_[c] = channel_of(channel_[c].name, ordinate_[c], length_factor_.has_value());
  }

  const std::vector<FileChannel>& channels() const override { return channel_; }
  double part() const override { return static_cast<double>(row_) / static_cast<double>(abscissa_.samples); }
  void rewind() override {
    row_ = 0;
    for (Column& column : column_) column.rewind();
  }
  bool read(SampleRows& rows) override {
    rows.clear();
    rows.channels = channel_.size();
    const auto end = std::min(abscissa_.samples, row_ + static_cast<std::int64_t>(kRowsAtOnce));
    for (; row_ < end; ++row_) {
      rows.time_s.push_back(abscissa_.time_s(row_));
      for (Column& column : column_) rows.value.push_back(column.next());
    }
    return rows.rows() > 0;
  }

 private:
  void find_function() {
    lines_.need("ID line 1");
    const std::string name(trimmed(lines_.line()));
    std::string rate_line;
    for (int id = 2; id <= 5; ++id) {
      lines_.need("ID lines 2 to 5");
      if (id == 4) rate_line = trimmed(lines_.line());
    }
    lines_.need("record 6");
    if (lines_.integer(0, 5, "function type") != 1) return pass_over(lines_);
    lines_.need("record 7");
    const std::int64_t type = lines_.integer(0, 10, "ordinate data type");
    if (type != 2 && type != 4)
      lines_.fail("ordinate data type " + std::to_string(type) + "; allowed: 2 or 4, real");
    Abscissa abscissa{.samples = lines_.integer(10, 10, "number of values"),
                      .first_s = lines_.number(30, 13, "abscissa minimum"),
                      .step_s = lines_.number(43, 13, "abscissa increment")};
    if (lines_.integer(20, 10, "abscissa spacing") != 1) lines_.fail("uneven abscissa; allowed: even");
    if (abscissa.samples < 1 || abscissa.samples > kMostUffSamples || !(abscissa.step_s > 0.0))
      lines_.fail("allowed: at least one value, and a positive increment");
    refine(rate_line, abscissa);
    if (!is_countable(abscissa.first_s) || !is_countable(abscissa.time_s(abscissa.samples)))
      lines_.fail(std::string("abscissa: ") + kTooFarOff);
    lines_.need("record 8");
    expect_seconds();
    lines_.need("record 9");
    ordinate_.push_back(ordinate(lines_, length_factor_));
    lines_.need("record 10");
    lines_.need("record 11");
    take(name, abscissa, type == 2 ? 6 : 4, type == 2 ? 13 : 20);
  }

  void expect_seconds() const {
    const std::string_view unit = lines_.field(47, 20);
    if (!unit.empty() && unit != "NONE" && unit != "s" && unit != "sec" && unit != "S" && unit != "SEC")
      lines_.fail("abscissa in \"" + std::string(unit) + "\"; allowed: s");
  }

  void take(const std::string& name, const Abscissa& abscissa, std::int64_t per_line, std::size_t width) {
    if (!seen_.insert(name).second) lines_.fail("channel " + name + " stands twice");
    if (!channel_.empty() && !(abscissa == abscissa_))
      lines_.fail("channel " + name + " has another abscissa than those before; allowed: the same");
    abscissa_ = abscissa;
    channel_.push_back({.name = name});
    column_.emplace_back(file_, name, lines_.place(), static_cast<std::size_t>(per_line), width);
    for (std::int64_t values = 0; values < abscissa.samples; values += per_line) {
      lines_.need("more values");
      if (lines_.is_marker())
        lines_.fail(std::to_string(values) + " values; allowed: " + std::to_string(abscissa.samples));
    }
    lines_.need("-1 in columns 5 and 6, which ends a data set");
    if (!lines_.is_marker()) lines_.fail("more than " + std::to_string(abscissa.samples) + " values");
  }

  const std::shared_ptr<const File> file_;
  Lines lines_;
  std::vector<FileChannel> channel_;
  std::vector<Ordinate> ordinate_;       ///< [channel]
  std::optional<double> length_factor_;  ///< of the data set 164 read last
  std::vector<Column> column_;
  Abscissa abscissa_;
  std::set<std::string> seen_;
  std::int64_t row_ = 0;
};

}  // namespace

std::unique_ptr<SampleSource> open_uff58_samples(const std::filesystem::path& file) {
  return std::make_unique<UniversalSamples>(file);
}

}  // namespace roadbalance
