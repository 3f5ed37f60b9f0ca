#include "tools/import/channel_units.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "common/config/section.hpp"
#include "common/text/format.hpp"
#include "host/recording/formats/units.hpp"

namespace roadbalance {
namespace {

/// Other bytes as \xNN: a unit may be in any encoding, and the record, JSON and terminals get it.
std::string ascii(const std::string& text) {
  std::string shown;
  for (const char c : text)
    shown += c >= ' ' && c <= '~' ? std::string(1, c) : format("\\x%02X", static_cast<unsigned>(c) & 0xFFU);
  return shown;
}

/// A person's words on one thing, by channel.
class Words {
 public:
  Words(const char* option, const std::vector<std::string>& words, const std::vector<FileChannel>& columns)
      : option_(option) {
    for (const std::string& word : words) {
      const std::size_t at = word.find('=');
      const std::string channel = at == std::string::npos ? "" : word.substr(0, at);
      if (!channel.empty() && std::ranges::find(columns, channel, &FileChannel::name) == columns.end())
        fail(word, "the file has no channel " + channel);
      if (std::ranges::find(words_, channel, &Word::channel) != words_.end())
        fail(word, "stands twice; allowed: once for all and once for each channel");
      words_.push_back({channel, at == std::string::npos ? word : word.substr(at + 1)});
    }
  }
  struct Word {
    std::string channel;  ///< empty: all
    std::string text;
  };
  /// The one for the channel, or else for all; nothing: there is none.
  const Word* of(const std::string& channel) const {
    for (const std::string& name : {channel, std::string()})
      if (const auto found = std::ranges::find(words_, name, &Word::channel); found != words_.end())
        return &*found;
    return nullptr;
  }
  [[noreturn]] void fail(const std::string& word, const std::string& reason) const {
    throw ConfigError(std::string(option_) + ": " + word + ": " + reason);
  }

 private:
  const char* option_;
  std::vector<Word> words_;
};

struct Sensitivity {
  double volts;  ///< at ...
  double m_s2;   ///< ... so much
};

/// "100mV/g", "10.2 mV/(m/s^2)"
std::optional<Sensitivity> sensitivity_of(std::string_view text) {
  double number = 0.0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, number);
  if (error != std::errc() || !(number > 0.0) || !std::isfinite(number)) return std::nullopt;
  const std::string_view rest(end, static_cast<std::size_t>(last - end));
  const std::size_t slash = rest.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  std::string_view per = rest.substr(slash + 1);
  if (per.starts_with('(') && per.ends_with(')')) per = per.substr(1, per.size() - 2);
  const auto volts = unit_named(rest.substr(0, slash)), of = unit_named(per);
  if (!volts || volts->quantity != Quantity::kVoltage || !of || of->quantity != Quantity::kAcceleration)
    return std::nullopt;
  return Sensitivity{number * volts->factor, of->factor};
}

class Understanding {
 public:
  Understanding(const std::filesystem::path& file, const std::vector<FileChannel>& columns,
                const UnitOptions& options)
      : file_(file),
        units_("--units", options.units, columns),
        sensitivity_("--sensitivity", options.sensitivity, columns) {}

  ChannelUnit of(const FileChannel& column, ChannelRole role) const {
    ChannelUnit found{.channel = column.name, .in_file = ascii(column.unit)};
    const auto* const units = units_.of(column.name);
    const auto* const sensitivity = sensitivity_.of(column.name);
    const bool is_road = role == ChannelRole::kRoad;
    const char* const si = is_road ? "m" : "m/s^2";
    const std::string& in_file = column.unit.empty() && column.quantity != si ? column.quantity : column.unit;
    const std::string name = units ? units->text : in_file;
    const auto unit = unit_named(name);
    const std::string by_units = units ? ", by --units " + name + what_the_file_says(column) : "";
    const bool is_voltage = unit && unit->quantity == Quantity::kVoltage;
    if (sensitivity && !is_road && (is_voltage || name.empty())) {
      take_sensitivity(unit ? unit->factor : 1.0, sensitivity->text, found);
      found.meaning += name.empty() ? "; V is assumed, for the file has no unit" : by_units;
      return found;
    }
    if (sensitivity && !sensitivity->channel.empty())
      sensitivity_.fail(sensitivity->text, "channel " + column.name + " is " +
                                               (is_road ? "no acceleration" : "in \"" + ascii(name) + "\"") +
                                               "; allowed: accelerations in V or mV");
    if (name.empty()) {
      found.meaning = std::string(si) + " is assumed, for the file has no unit";
      return found;
    }
    if (!unit || unit->quantity != (is_road ? Quantity::kLength : Quantity::kAcceleration)) {
      const std::string allowed = std::string("; allowed: ") + (is_road ? kLengthUnits : kAccelerationUnits);
      if (units) units_.fail(name, "is no unit of channel " + column.name + allowed);
      throw ConfigError(file_.string() + ": channel " + column.name + ": its unit is \"" + ascii(name) + '"' +
                        allowed +
                        (is_voltage ? ", or --sensitivity " + column.name + "=100mV/g with its value"
                                    : ", or --units " + column.name + "=g with what it is"));
    }
    found.factor = unit->factor;
    found.meaning = format("%.9g %s each", unit->factor, si) + by_units;
    return found;
  }

 private:
  static std::string what_the_file_says(const FileChannel& column) {
    return column.unit.empty() ? "" : "; the file says \"" + ascii(column.unit) + '"';
  }
  void take_sensitivity(double volts_each, const std::string& text, ChannelUnit& found) const {
    const auto sensitivity = sensitivity_of(text);
    if (!sensitivity)
      sensitivity_.fail(text, "allowed: volts per acceleration, as 100mV/g or 10.2mV/(m/s^2)");
    found.factor = volts_each * sensitivity->m_s2 / sensitivity->volts;
    found.meaning = format("%.9g m/s^2 each, by --sensitivity ", found.factor) + text;
  }

  const std::filesystem::path file_;
  const Words units_, sensitivity_;
};

}  // namespace

std::vector<ChannelUnit> understand_units(const std::filesystem::path& file,
                                          const std::vector<FileChannel>& columns,
                                          const VehicleConfig& vehicle, const UnitOptions& options) {
  const Understanding understanding(file, columns, options);
  std::vector<ChannelUnit> all;
  for (const FileChannel& column : columns) {
    all.push_back({.channel = column.name});
    for (const NodeConfig& node : vehicle.node)
      for (const ChannelConfig& channel : node.channel)
        if (channel.name == column.name && channel.role != ChannelRole::kUnused)
          all.back() = understanding.of(column, channel.role);
  }
  return all;
}

}  // namespace roadbalance
