#include "common/config/node_wiring.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "common/types/scan.hpp"

namespace roadbalance {
namespace {

// In the order of SignalQuantity.
constexpr std::array kQuantityNames{"wheel_speed", "vehicle_speed", "steering_angle", "pulse_counter",
                                    "other"};

void parse_counter(Section counter, SignalConfig& s) {
  constexpr std::int64_t kMost = std::int64_t{1} << 32;
  s.counter.modulus = counter.integer_or("modulus", 2, kMost, s.counter.modulus);
  s.counter.invalid_code.reset();
  if (counter.has("invalid_code")) s.counter.invalid_code = counter.integer("invalid_code", 0, kMost);
  s.counter.step = counter.integer_or("step", 1, s.counter.modulus - 1, s.counter.step);
  s.latency.mean_s = 1e-3 * counter.number_or("latency_ms", {0, 1000}, 0.0);
  s.latency.mean_sigma_s = 1e-3 * counter.number_or("latency_sigma_ms", {0, 1000}, 0.0);
  s.latency.jitter_s = 1e-3 * counter.number_or("jitter_ms", {0, 1000}, 0.0);
  // For two messages, each within three times the rms.
  s.counter.jitter_s = std::max(s.counter.jitter_s, 6 * s.latency.jitter_s);
  counter.finish();
}

SignalConfig parse_signal(Section signal, const std::vector<std::string>& wheels) {
  SignalConfig s;
  s.name = signal.text("name");
  s.message = signal.text("message");
  s.signal = signal.text("signal");
  const std::vector<std::string> quantities(kQuantityNames.begin(), kQuantityNames.end());
  s.quantity = static_cast<SignalQuantity>(
      signal.choice_or("quantity", quantities, static_cast<std::size_t>(SignalQuantity::kOther)));
  if (s.quantity == SignalQuantity::kWheelSpeed || s.quantity == SignalQuantity::kPulseCounter)
    s.wheel = wheels[signal.choice("wheel", wheels)];
  if (auto counter = signal.section_if("counter")) {
    if (s.quantity != SignalQuantity::kPulseCounter)
      signal.fail("counter", "only a pulse_counter has one; allowed: quantity = \"pulse_counter\"");
    parse_counter(std::move(*counter), s);
  }
  signal.finish();
  return s;
}

CanConfig parse_can(Section can, int first_signal, const std::vector<std::string>& wheels) {
  CanConfig c;
  c.interface = can.text("interface");
  c.role = can.choice("role", {"vehicle", "sensor"}) == 0 ? CanRole::kVehicle : CanRole::kSensor;
  c.dbc = can.text_or("dbc", "");
  if (can.has("accelerometer_id")) {
    if (c.role != CanRole::kSensor)
      can.fail("accelerometer_id", "our modules are on no bus of the car's own; allowed: role = \"sensor\"");
    c.accelerometer_id =
        static_cast<std::uint32_t>(can.integer("accelerometer_id", 0, kHighestAccelerometerId));
  }
  c.first_signal = first_signal;
  for (Section& signal : can.sections("signal")) c.signal.push_back(parse_signal(std::move(signal), wheels));
  if (!c.signal.empty() && c.dbc.empty()) can.fail("dbc", "missing, but there are signals it describes");
  can.finish();
  return c;
}

/// Every name once, and not more signals than a sample can number.
void check_signals(const Section& node, const NodeWiring& wiring) {
  if (wiring.signals() > kMostSignals)
    node.fail("can", "has " + std::to_string(wiring.signals()) + " signals; allowed: at most 256");
  std::set<std::string> names;
  for (const CanConfig& can : wiring.can)
    for (const SignalConfig& signal : can.signal)
      if (!names.insert(signal.name).second) node.fail("can", "signal \"" + signal.name + "\" stands twice");
}

LineConfig parse_line(Section line, std::set<int>& used) {
  const auto gpio = [&](const char* key) {
    const auto offset = static_cast<int>(line.integer(key, 0, 1023));
    if (!used.insert(offset).second) line.fail(key, "GPIO " + std::to_string(offset) + " is used twice");
    return offset;
  };
  LineConfig l;
  l.line = static_cast<int>(line.integer("line", 0, kEncoderLines - 1));
  l.tooth_gpio = gpio("tooth_gpio");
  if (line.has("direction_gpio")) l.direction_gpio = gpio("direction_gpio");
  if (line.has("zero_mark_gpio")) l.zero_mark_gpio = gpio("zero_mark_gpio");
  line.finish();
  return l;
}

}  // namespace

const char* name_of(SignalQuantity quantity) {
  return kQuantityNames[static_cast<std::size_t>(quantity)];
}

std::size_t NodeWiring::signals() const {
  return can.empty() ? 0 : static_cast<std::size_t>(can.back().first_signal) + can.back().signal.size();
}

const SignalConfig* NodeWiring::signal(int number) const {
  for (const CanConfig& one : can) {
    const int place = number - one.first_signal;
    if (0 <= place && place < static_cast<int>(one.signal.size()))
      return &one.signal[static_cast<std::size_t>(place)];
  }
  return nullptr;
}

const LineConfig* NodeWiring::line_at(int number) const {
  const auto found = std::ranges::find(line, number, &LineConfig::line);
  return found == line.end() ? nullptr : &*found;
}

NodeWiring NodeWiring::take(Section& node, const std::vector<std::string>& wheels) {
  NodeWiring wiring;
  wiring.front_end = node.texts_or("front_end", {});
  wiring.loop_back = node.boolean_or("loop_back", false);
  for (Section& can : node.sections("can"))
    wiring.can.push_back(parse_can(std::move(can), static_cast<int>(wiring.signals()), wheels));
  check_signals(node, wiring);
  std::set<int> used, lines;
  for (Section& line : node.sections("line")) {
    wiring.line.push_back(parse_line(std::move(line), used));
    if (!lines.insert(wiring.line.back().line).second)
      node.fail("line", "line " + std::to_string(wiring.line.back().line) + " stands twice");
  }
  return wiring;
}

}  // namespace roadbalance
