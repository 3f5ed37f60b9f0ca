#include "tools/rb/bus_distance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>

#include "common/config/section.hpp"
#include "common/dbc/dbc_reading.hpp"
#include "common/dbc/si_unit.hpp"

namespace roadbalance {
namespace {

constexpr double kFastest_m_s = 100.0;
constexpr double kHardest_m_s2 = 15.0;
/// Error that a speed message may have: of its scale, and because it is a little older.
constexpr double kSpeedShare = 0.1, kSpeedOff_m_s = 1.0;

struct Signal {
  const DbcMessage* message;
  const DbcSignal* signal;
  std::string name() const { return message->name + "." + signal->name; }
  bool is_in(const CanFrame& frame) const {
    return frame.id == message->id && frame.extended == message->extended;
  }
};

Signal find(const Dbc& dbc, const std::string& name) {
  const auto point = name.find('.');
  const DbcMessage* const message = dbc.message(name.substr(0, point));
  if (point == std::string::npos || !message)
    throw ConfigError(name + ": " + dbc.file + " has no such message; a signal is MESSAGE.SIGNAL");
  const DbcSignal* const signal = message->signal(name.substr(point + 1));
  if (!signal) throw ConfigError(name + ": " + dbc.file + ": " + message->name + " has no such signal");
  return {message, signal};
}

/// In m/s per unit of its DBC file; nothing if it is no speed.
std::optional<double> speed_factor(const DbcSignal& signal) {
  const auto unit = si_unit(signal.unit);
  if (!unit || std::string(unit->name) != "m/s") return std::nullopt;
  return unit->factor;
}

class SpeedIntegral {
 public:
  SpeedIntegral(Signal signal, double factor) : signal_(signal), factor_(factor) {
    distance_.signal = signal.name();
  }
  void take(const LoggedFrame& logged) {
    if (!signal_.is_in(logged.frame)) return;
    ++distance_.messages;
    const DbcReading reading = read_signal(*signal_.message, *signal_.signal, logged.frame);
    if (reading.status != DbcReading::Status::kOk) {
      ++distance_.refused;
      return;
    }
    const double speed = reading.value * factor_;
    const double elapsed_s = newest_m_s_ ? 1e-9 * static_cast<double>(logged.time_ns - time_ns_) : 0.0;
    if (elapsed_s > kLongestSilence_s) {
      ++distance_.silences;
    } else if (elapsed_s > 0.0) {
      distance_.seconds += elapsed_s;
      distance_.metres += 0.5 * elapsed_s * (*newest_m_s_ + speed);
    }
    newest_m_s_ = speed;
    time_ns_ = logged.time_ns;
  }
  const SpeedDistance& distance() const { return distance_; }
  const Signal& signal() const { return signal_; }
  /// Nothing if it is too old to show anything at an instant.
  std::optional<double> speed_at(std::int64_t time_ns) const {
    if (!newest_m_s_ || 1e-9 * static_cast<double>(time_ns - time_ns_) > kLongestSilence_s)
      return std::nullopt;
    return newest_m_s_;
  }

 private:
  Signal signal_;
  double factor_;
  std::optional<double> newest_m_s_;
  std::int64_t time_ns_ = 0;
  SpeedDistance distance_;
};

std::int64_t raw_code(const Signal& counter, const CanFrame& frame) {
  return static_cast<std::int64_t>(counter.signal->place.bits(frame).value_or(0));
}

bool is_valid(const Signal& counter, const CanFrame& frame) {
  return read_signal(*counter.message, *counter.signal, frame).status == DbcReading::Status::kOk;
}

/// The step of which all codes of the log, counted from the first, are multiples.
std::int64_t step_of(const std::vector<LoggedFrame>& log, const Signal& counter) {
  std::int64_t step = std::int64_t{1} << counter.signal->place.length;
  std::optional<std::int64_t> first;
  for (const LoggedFrame& logged : log) {
    if (!counter.is_in(logged.frame) || !is_valid(counter, logged.frame)) continue;
    const std::int64_t code = raw_code(counter, logged.frame);
    if (!first) first = code;
    step = std::gcd(step, code - *first);
  }
  return step;
}

double worth_of_a_count(const Signal& counter, std::optional<double> metres_per_count) {
  const CanSignal& place = counter.signal->place;
  if (place.number != CanNumber::kUnsigned || place.length < 2 || place.length > 32)
    throw ConfigError(counter.name() + ": a counter is an unsigned number of 2 to 32 bits");
  if (metres_per_count) return *metres_per_count;
  if (counter.signal->unit != "m" || !(place.scale > 0.0))
    throw ConfigError(counter.name() + ": its unit is \"" + counter.signal->unit +
                      "\", not m: --metres-per-count must say what a count is worth");
  return place.scale;
}

/// The counter's own message has the speed of the same instant; any other will do.
std::optional<double> speed_beside(const std::vector<SpeedIntegral>& speeds, const Signal& counter,
                                   std::int64_t time_ns) {
  std::optional<double> speed;
  for (const SpeedIntegral& one : speeds)
    if (const auto its = one.speed_at(time_ns); its && (!speed || one.signal().message == counter.message))
      speed = std::abs(*its);
  return speed;
}

/// Bounds of the mean speed between two instants whose speeds are known, whatever the car did in between.
RateBounds bounds(double before_m_s, double after_m_s, double elapsed_s, double metres_per_count) {
  const auto [least, most] = std::minmax(before_m_s, after_m_s);
  const double between = 0.5 * kHardest_m_s2 * elapsed_s + kSpeedOff_m_s;
  return {.low_hz = (least * (1.0 - kSpeedShare) - between) / metres_per_count,
          .high_hz = (most * (1.0 + kSpeedShare) + between) / metres_per_count};
}

}  // namespace

BusDistance bus_distance(const std::vector<LoggedFrame>& log, const Dbc& dbc, const std::string& counter_name,
                         std::optional<double> metres_per_count) {
  const Signal counter = find(dbc, counter_name);
  BusDistance result;
  CounterDistance& counted = result.counter;
  counted.signal = counter.name();
  counted.metres_per_count = worth_of_a_count(counter, metres_per_count);
  counted.step = step_of(log, counter);
  CounterUnwrap unwrap({.modulus = std::int64_t{1} << counter.signal->place.length,
                        .invalid_code = std::nullopt,
                        .step = counted.step,
                        .highest_rate_hz = kFastest_m_s / counted.metres_per_count,
                        .highest_change_hz_s = kHardest_m_s2 / counted.metres_per_count,
                        .jitter_s = 0.02});
  std::vector<SpeedIntegral> speeds;
  for (const DbcMessage& message : dbc.messages)
    for (const DbcSignal& signal : message.signals)
      if (const auto factor = speed_factor(signal)) speeds.emplace_back(Signal{&message, &signal}, *factor);

  std::int64_t before = 0, time_ns = 0;
  std::optional<double> speed_before_m_s;
  for (const LoggedFrame& logged : log) {
    ++result.frames;
    for (SpeedIntegral& speed : speeds) speed.take(logged);
    if (!counter.is_in(logged.frame)) continue;
    ++counted.messages;
    const auto speed_m_s = speed_beside(speeds, counter, logged.time_ns);
    std::optional<RateBounds> known;
    if (speed_m_s && speed_before_m_s)
      known = bounds(*speed_before_m_s, *speed_m_s, 1e-9 * static_cast<double>(logged.time_ns - time_ns),
                     counted.metres_per_count);
    const auto outcome =
        unwrap.take(logged.time_ns, raw_code(counter, logged.frame), is_valid(counter, logged.frame), known);
    if (outcome == CounterUnwrap::Outcome::kInvalid || outcome == CounterUnwrap::Outcome::kOutOfOrder)
      continue;
    if (outcome == CounterUnwrap::Outcome::kJoined) {
      counted.counts += unwrap.count() - before;
      counted.seconds += 1e-9 * static_cast<double>(logged.time_ns - time_ns);
    }
    before = unwrap.count();
    time_ns = logged.time_ns;
    speed_before_m_s = speed_m_s;
  }
  if (counted.messages == 0)
    throw ConfigError(counter.name() + ": the log holds no frame of " + counter.message->name);
  counted.counters = unwrap.counters();
  counted.runs = unwrap.run();
  counted.metres = static_cast<double>(counted.counts) * counted.metres_per_count;
  for (const SpeedIntegral& speed : speeds) result.speed.push_back(speed.distance());
  return result;
}

nlohmann::ordered_json distance_json(const BusDistance& distance) {
  const CounterDistance& c = distance.counter;
  nlohmann::ordered_json json{{"counter",
                               {{"signal", c.signal},
                                {"messages", c.messages},
                                {"counts", c.counts},
                                {"step", c.step},
                                {"wraps", c.counters.wraps},
                                {"runs", c.runs},
                                {"invalid", c.counters.invalid},
                                {"out_of_order", c.counters.out_of_order},
                                {"ambiguous", c.counters.ambiguous},
                                {"implausible", c.counters.implausible},
                                {"metres_per_count", c.metres_per_count},
                                {"seconds", c.seconds},
                                {"metres", c.metres}}},
                              {"speeds", nlohmann::ordered_json::array()},
                              {"angle", nullptr}};
  for (const SpeedDistance& s : distance.speed)
    json["speeds"].push_back({{"signal", s.signal},
                              {"messages", s.messages},
                              {"refused", s.refused},
                              {"silences", s.silences},
                              {"seconds", s.seconds},
                              {"metres", s.metres},
                              {"counter_minus_speed_m", c.metres - s.metres}});
  return json;
}

std::vector<std::string> distance_lines(const BusDistance& distance) {
  char line[400];
  std::vector<std::string> lines;
  const CounterDistance& c = distance.counter;
  std::snprintf(
      line, sizeof line,
      "%s: %lld counts in steps of %lld, %lld wraps, %.2f s: %.1f m; %lld messages, %lld invalid, %lld out "
      "of order",
      c.signal.c_str(), static_cast<long long>(c.counts), static_cast<long long>(c.step),
      static_cast<long long>(c.counters.wraps), c.seconds, c.metres, static_cast<long long>(c.messages),
      static_cast<long long>(c.counters.invalid), static_cast<long long>(c.counters.out_of_order));
  lines.emplace_back(line);
  if (c.runs != 1) {
    std::snprintf(
        line, sizeof line,
        "%s: BROKEN into %lld runs: %lld times more than one number of wraps was possible, %lld times none; "
        "nothing is counted across",
        c.signal.c_str(), static_cast<long long>(c.runs), static_cast<long long>(c.counters.ambiguous),
        static_cast<long long>(c.counters.implausible));
    lines.emplace_back(line);
  }
  for (const SpeedDistance& s : distance.speed) {
    const double off = c.metres - s.metres;
    std::snprintf(
        line, sizeof line,
        "%s: %.1f m in %.2f s of %lld messages (%lld refused, %lld silences); counter %+.1f m (%+.2f %%)",
        s.signal.c_str(), s.metres, s.seconds, static_cast<long long>(s.messages),
        static_cast<long long>(s.refused), static_cast<long long>(s.silences), off,
        s.metres > 0.0 ? 100.0 * off / s.metres : 0.0);
    lines.emplace_back(line);
  }
  lines.emplace_back(
      "angle: none. A speed carries no angle, and a count only one turned through: it needs a zero mark of "
      "its own");
  return lines;
}

}  // namespace roadbalance
