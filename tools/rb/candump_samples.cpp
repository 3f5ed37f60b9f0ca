#include "tools/rb/candump_samples.hpp"

#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "common/config/section.hpp"
#include "firmware/backends/dbc/candump.hpp"
#include "firmware/backends/dbc/dbc_reading.hpp"
#include "host/exchange/candump_writer.hpp"
#include "host/exchange/units.hpp"
#include "tools/rb/csv_table.hpp"

namespace roadbalance {
namespace {

constexpr double kNoSample = std::numeric_limits<double>::quiet_NaN();

/// Remote frames have no data, error frames an identifier beyond all others.
bool is_passed_over(const std::string& line) {
  const std::size_t hash = line.find('#'), space = line.rfind(' ', hash);
  if (line.empty() || hash == std::string::npos || space == std::string::npos) return line.empty();
  const bool is_error = hash - space - 1 == 8 && line[space + 1] >= '2';
  return line.compare(hash, 2, "#R") == 0 || is_error;
}

class LogReader {
 public:
  LogReader(std::string log, const Dbc& dbc) : log_(std::move(log)), dbc_(dbc) {
    for (const DbcMessage& message : dbc_.messages) message_[{message.id, message.extended}] = {&message, {}};
  }

  SampleTable read() {
    std::ifstream file(log_);
    if (!file) throw std::system_error(errno, std::generic_category(), "open " + log_);
    for (std::string line; std::getline(file, line);) {
      ++line_;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      if (const auto logged = parse_candump(line))
        take(*logged);
      else if (!is_passed_over(line))
        fail("\"" + line.substr(0, 60) + "\" is no frame; allowed: (seconds.microseconds) interface ID#DATA");
    }
    if (table_.name.empty()) fail("no frame that " + dbc_.file + " knows a signal of");
    for (auto& column : table_.value_si) column.resize(table_.time_s.size(), kNoSample);
    return std::move(table_);
  }

 private:
  struct Known {
    const DbcMessage* message;
    std::optional<std::size_t> first_column;  // of its signals, once a frame has come
  };

  [[noreturn]] void fail(const std::string& reason) const {
    throw ConfigError(log_ + ":" + std::to_string(line_) + ": " + reason);
  }

  void take(const LoggedFrame& logged) {
    const auto known = message_.find({logged.frame.id, logged.frame.extended});
    if (known == message_.end()) return;
    if (!interface_.empty() && interface_ != logged.interface)
      fail("frames of " + logged.interface + " and " + interface_ + "; allowed: those of one bus");
    interface_ = logged.interface;
    if (known->second.message->name == kCandumpStart && known->second.message->size == 0)
      return begin_recording(logged.time_ns);
    begin_row(logged.time_ns);
    if (!known->second.first_column) known->second.first_column = add_columns(*known->second.message);
    add(logged.frame, *known->second.message, *known->second.first_column);
  }

  void begin_recording(std::int64_t time_ns) {
    if (first_ns_) fail("a recording's start behind its frames; allowed: the log of one recording");
    first_ns_ = last_ns_ = time_ns;
  }

  void begin_row(std::int64_t time_ns) {
    if (!table_.time_s.empty() && time_ns == last_ns_) return;
    if (first_ns_ && time_ns < last_ns_) fail("its time goes back; allowed: frames in order of time");
    if (!first_ns_) first_ns_ = time_ns;
    last_ns_ = time_ns;
    table_.time_s.push_back(1e-9 * static_cast<double>(time_ns - *first_ns_));
  }

  std::size_t add_columns(const DbcMessage& message) {
    const std::size_t first = table_.name.size();
    for (const DbcSignal& signal : message.signals) {
      const auto refuse = [&](const std::string& reason) {
        throw ConfigError(dbc_.file + ":" + std::to_string(signal.line) + ": " + signal.name + ": " + reason);
      };
      for (const std::string& name : table_.name)
        if (name == signal.name) refuse("stands in two messages of the log; allowed: one");
      const auto factor = is_reference_column(signal.name) ? 1.0 : factor_of_unit(signal.unit);
      if (!factor) refuse("unit \"" + signal.unit + "\"; allowed: " + kKnownUnits);
      table_.name.push_back(signal.name);
      table_.value_si.emplace_back();
      factor_.push_back(*factor);
    }
    return first;
  }

  void add(const CanFrame& frame, const DbcMessage& message, std::size_t first) {
    for (std::size_t s = 0; s < message.signals.size(); ++s) {
      const DbcReading reading = read_signal(message, message.signals[s], frame);
      if (reading.status == DbcReading::Status::kTooShort)
        fail(std::to_string(frame.size) + " bytes; message " + message.name + " has " +
             std::to_string(message.size));
      if (reading.status != DbcReading::Status::kOk) continue;
      auto& column = table_.value_si[first + s];
      if (column.size() == table_.time_s.size())
        fail(message.signals[s].name + " stands twice at one instant");
      column.resize(table_.time_s.size() - 1, kNoSample);
      column.push_back(reading.value * factor_[first + s]);
    }
  }

  const std::string log_;
  const Dbc& dbc_;
  std::map<std::pair<std::uint32_t, bool>, Known> message_;
  SampleTable table_;
  std::vector<double> factor_;  // [column]
  std::string interface_;
  std::optional<std::int64_t> first_ns_;  // from which times count
  std::int64_t last_ns_ = 0, line_ = 0;
};

}  // namespace

SampleTable read_candump_samples(const std::filesystem::path& log, const std::filesystem::path& dbc) {
  const Dbc known = Dbc::read_file(dbc.string());
  return LogReader(log.string(), known).read();
}

}  // namespace roadbalance
