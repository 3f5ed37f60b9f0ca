#include "tools/rb/readings_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "common/types/angle_units.hpp"
#include "host/recording/formats/csv_text.hpp"
#include "tools/import/csv_samples.hpp"

namespace roadbalance {
namespace {

constexpr std::string_view kOfWeight = "weight ", kOfSigma = "sigma ";

std::optional<double> number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Value of a one in the last digit of a number as it is written: 0.01 of 3.40, 10 of 1.7e2.
double last_digit(std::string_view text) {
  const std::size_t exponent = std::min(text.find_first_of("eE"), text.size());
  const std::size_t point = text.substr(0, exponent).find('.');
  const double digits = point == std::string_view::npos ? 0.0 : static_cast<double>(exponent - point - 1);
  std::string_view power_text = text.substr(std::min(exponent + 1, text.size()));
  if (power_text.starts_with('+')) power_text.remove_prefix(1);
  const double power = number(power_text).value_or(0.0);
  return std::pow(10.0, power - digits);
}

/// AMOUNT@DEGREES
struct Polar {
  std::complex<double> value;
  double digits_variance;  ///< a last digit stands for anything within itself, evenly
};
std::optional<Polar> polar(std::string_view text) {
  const std::size_t at = text.find('@');
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view amount_text = text.substr(0, at), angle_text = text.substr(at + 1);
  const auto amount = number(amount_text), degrees = number(angle_text);
  if (!amount || !degrees || *amount < 0.0) return std::nullopt;
  const double across = *amount * last_digit(angle_text) * kDegree;
  return Polar{std::polar(*amount, *degrees * kDegree),
               (std::pow(last_digit(amount_text), 2) + across * across) / 12.0};
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : lines_(open_again_and_again(file)) {}

  ReadingsFile read() {
    read_names();
    read_units();
    while (lines_.next()) read_run();
    if (table_.readings.run.empty()) lines_.fail("run", "there is none; allowed: a row for each run");
    return std::move(table_);
  }

 private:
  enum class Kind { kRun, kSpeed, kWeight, kChannel, kSigma };
  struct Column {
    std::string name;
    Kind kind;
    std::size_t place = 0;  ///< of its plane or channel
  };

  void read_names() {
    if (!lines_.next()) lines_.fail("header", "the file is empty; allowed: run and the names of columns");
    if (lines_.cells()[0] != "run")
      lines_.fail(std::string(lines_.cells()[0]), "is the first column; allowed: run");
    std::set<std::string> seen;
    for (const std::string_view cell : lines_.cells()) {
      const std::string name(unprotected_text(cell));
      if (name.empty()) lines_.fail("header", "a column has no name");
      if (!seen.insert(name).second) lines_.fail(name, "stands twice");
      column_.push_back({name, kind_of(name)});
      Column& column = column_.back();
      if (column.kind == Kind::kWeight)
        column.place = add(name.substr(kOfWeight.size()), table_.readings.plane);
      if (column.kind == Kind::kChannel) column.place = add(name, table_.readings.channel);
    }
    for (Column& column : column_) {
      if (column.kind != Kind::kSigma) continue;
      const auto& channels = table_.readings.channel;
      const auto found = std::ranges::find(channels, column.name.substr(kOfSigma.size()));
      if (found == channels.end())
        lines_.fail(column.name, "there is no such channel; allowed: sigma CHANNEL");
      column.place = static_cast<std::size_t>(found - channels.begin());
    }
    if (std::ranges::count(column_, Kind::kSpeed, &Column::kind) > 1)
      lines_.fail("header", "two columns are the speed; allowed: speed or turns");
    if (table_.readings.plane.empty())
      lines_.fail("header", "no column is a weight; allowed: \"weight PLANE\" for each plane");
    if (table_.readings.channel.empty())
      lines_.fail("header", "no column is a reading; allowed: one for each channel, by its name");
  }

  Kind kind_of(const std::string& name) const {
    if (column_.empty()) return Kind::kRun;
    if (name == "speed" || name == "turns") return Kind::kSpeed;
    if (name.starts_with(kOfWeight)) return Kind::kWeight;
    return name.starts_with(kOfSigma) ? Kind::kSigma : Kind::kChannel;
  }
  static std::size_t add(const std::string& name, std::vector<std::string>& names) {
    names.push_back(name);
    return names.size() - 1;
  }

  void read_units() {
    if (!lines_.next()) lines_.fail("units", "missing; allowed: a second row with the unit of each column");
    check_width();
    for (std::size_t c = 1; c < column_.size(); ++c) {
      const std::string unit(lines_.cells()[c]);
      if (unit.find('@') != std::string::npos)
        lines_.fail(column_[c].name, "\"" + unit + "\" is no unit; allowed: a second row with the units");
      Unit& of_kind = column_[c].kind == Kind::kSpeed    ? speed_
                      : column_[c].kind == Kind::kWeight ? weight_
                                                         : reading_;
      if (!of_kind.column.empty() && unit != of_kind.unit)
        lines_.fail(column_[c].name, "is in \"" + unit + "\", but " + of_kind.column + " in \"" +
                                         of_kind.unit +
                                         "\"; allowed: one unit for all weights, and one for all readings");
      of_kind = {column_[c].name, unit};
    }
    table_.speed_unit = speed_.unit;
    table_.weight_unit = weight_.unit;
    table_.reading_unit = reading_.unit;
  }

  void read_run() {
    check_width();
    Readings::Run run{.name = std::string(unprotected_text(lines_.cells()[0])),
                      .speed = {},
                      .weight = std::vector<std::complex<double>>(table_.readings.plane.size()),
                      .reading = std::vector<Reading>(table_.readings.channel.size())};
    if (run.name.empty()) lines_.fail("run", "is empty; allowed: a name");
    if (std::ranges::find(table_.readings.run, run.name, &Readings::Run::name) != table_.readings.run.end())
      lines_.fail("run", run.name + " stands twice; allowed: a name for each");
    for (std::size_t c = 1; c < column_.size(); ++c) read_cell(column_[c], lines_.cells()[c], run);
    table_.readings.run.push_back(std::move(run));
  }

  void read_cell(const Column& column, std::string_view cell, Readings::Run& run) const {
    const bool may_be_empty = column.kind == Kind::kWeight || column.kind == Kind::kSigma;
    if (may_be_empty && cell.empty()) return;
    const auto wrong = [&](const char* allowed) {
      lines_.fail(column.name, "\"" + std::string(cell) + "\" of run " + run.name + "; allowed: " + allowed);
    };
    switch (column.kind) {
      case Kind::kRun:
        return;
      case Kind::kSpeed:
        run.speed = number(cell);
        if (!run.speed || !(*run.speed > 0.0)) wrong("a number above 0");
        return;
      case Kind::kWeight: {
        const auto weight = polar(cell);
        if (!weight && number(cell) != 0.0) wrong("AMOUNT@DEGREES, or nothing");
        if (weight) run.weight[column.place] = weight->value;
        return;
      }
      case Kind::kChannel: {
        const auto reading = polar(cell);
        if (!reading) wrong("AMPLITUDE@DEGREES");
        run.reading[column.place].vector = reading->value;
        run.reading[column.place].digits_variance = reading->digits_variance;
        return;
      }
      case Kind::kSigma: {
        const auto sigma = number(cell);
        if (!sigma || !(*sigma > 0.0)) wrong("a number above 0, or nothing");
        run.reading[column.place].sigma = sigma;
        return;
      }
    }
  }

  void check_width() const {
    if (lines_.cells().size() != column_.size())
      lines_.fail("row", std::to_string(lines_.cells().size()) +
                             " cells; allowed: " + std::to_string(column_.size()) + " as in the header");
  }

  CsvLines lines_;
  std::vector<Column> column_;
  struct Unit {
    std::string column, unit;
  };
  Unit speed_, weight_, reading_;
  ReadingsFile table_;
};

}  // namespace

ReadingsFile ReadingsFile::read(const std::filesystem::path& file) {
  return Reader(file).read();
}

}  // namespace roadbalance
