#include "tools/views/signal_survey.hpp"

#include <algorithm>
#include <cstdio>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

const char* unit_of(SignalQuantity quantity) {
  switch (quantity) {
    case SignalQuantity::kWheelSpeed:
    case SignalQuantity::kVehicleSpeed:
      return "m/s";
    case SignalQuantity::kSteeringAngle:
      return "rad";
    case SignalQuantity::kPulseCounter:
      return "pulses";
    case SignalQuantity::kOther:
      break;
  }
  return "";
}

/// nullptr if the vehicle has no such signal.
const SignalConfig* find_signal(const VehicleConfig* vehicle, std::int32_t node, int number) {
  const NodeConfig* config = vehicle ? vehicle->node_with_id(node) : nullptr;
  return config ? config->wiring.signal(number) : nullptr;
}

void add_sample(const SignalSample& sample, SignalSurvey::Signal& signal) {
  const std::int64_t time_ns = to_ns(sample.time);
  if (signal.samples == 0) signal.least = signal.greatest = sample.value;
  if (signal.samples == 0 || time_ns < signal.first_ns)
    signal.first_ns = time_ns, signal.first = sample.value;
  if (signal.samples == 0 || time_ns >= signal.last_ns) signal.last_ns = time_ns, signal.last = sample.value;
  signal.least = std::min(signal.least, sample.value);
  signal.greatest = std::max(signal.greatest, sample.value);
  ++signal.samples;
}

}  // namespace

void SignalSurvey::add(std::string_view channel, std::span<const std::uint8_t> data) {
  SealedBlock block;
  if (channel.ends_with("_SIGNAL") && accept(data, block) == Refusal::kNone) add(block);
}

void SignalSurvey::add(const SealedBlock& block) {
  if (block.kind != BlockKind::kSignal) return;
  const NodeEpoch key{block.header.node, block.header.epoch};
  if (!seen_[key].insert(block.header.sequence)) return;
  for (const SignalSample& sample : decode_signal(block).unpack())
    add_sample(sample, signals_[key][sample.signal]);
}

const std::map<int, SignalSurvey::Signal>& SignalSurvey::of(NodeEpoch key) const {
  static const std::map<int, Signal> kNone;
  const auto found = signals_.find(key);
  return found == signals_.end() ? kNone : found->second;
}

Json signals_json(const SignalSurvey& survey, const VehicleConfig* vehicle) {
  Json list = Json::array();
  for (const auto& [key, signals] : survey.all())
    for (const auto& [number, signal] : signals) {
      const SignalConfig* config = find_signal(vehicle, key.first, number);
      Json entry{{"node", key.first}, {"epoch", key.second}, {"signal", number}};
      entry["name"] = config ? Json(config->name) : Json(nullptr);
      entry["quantity"] = config ? Json(name_of(config->quantity)) : Json(nullptr);
      entry["unit"] =
          config && *unit_of(config->quantity) != '\0' ? Json(unit_of(config->quantity)) : Json(nullptr);
      entry["wheel"] = config && !config->wheel.empty() ? Json(config->wheel) : Json(nullptr);
      entry.update(Json{{"samples", signal.samples},
                        {"first_ns", signal.first_ns},
                        {"last_ns", signal.last_ns},
                        {"first", signal.first},
                        {"last", signal.last},
                        {"least", signal.least},
                        {"greatest", signal.greatest}});
      list.push_back(std::move(entry));
    }
  return list;
}

std::vector<std::string> signal_lines(const SignalSurvey& survey, NodeEpoch key,
                                      const VehicleConfig* vehicle) {
  std::vector<std::string> lines;
  for (const auto& [number, signal] : survey.of(key)) {
    const SignalConfig* config = find_signal(vehicle, key.first, number);
    char text[200];
    std::snprintf(text, sizeof text, ": %lld samples in %.1f s, first %g, last %g, least %g, greatest %g %s",
                  static_cast<long long>(signal.samples),
                  static_cast<double>(signal.last_ns - signal.first_ns) * 1e-9, signal.first, signal.last,
                  signal.least, signal.greatest, config ? unit_of(config->quantity) : "");
    std::string line = "signal " + (config ? config->name : std::to_string(number)) + text;
    while (line.back() == ' ') line.pop_back();
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace roadbalance
