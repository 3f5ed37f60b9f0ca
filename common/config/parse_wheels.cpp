#include "common/config/parse_wheels.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "common/config/parse_balancing.hpp"
#include "common/link/block.hpp"

namespace roadbalance {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

EncoderConfig parse_encoder(Section encoder) {
  EncoderConfig e;
  e.pulses_per_turn = static_cast<int>(encoder.integer("pulses_per_turn", 1, 100'000));
  e.zero_mark = encoder.boolean_or("zero_mark", true);
  e.quadrature = encoder.boolean_or("quadrature", false);
  e.datum_rad = kRadiansPerDegree * encoder.number_or("datum_deg", {-360, 360}, 0.0);
  e.datum_sigma_rad = kRadiansPerDegree * encoder.number_or("datum_sigma_deg", {0, 180}, 0.0);
  e.steering_ratio = encoder.number_or("steering_ratio", {-1, 1}, 0.0);
  e.counter = encoder.text_or("counter", "");
  if (!e.counter.empty() && e.quadrature)
    encoder.fail("quadrature", "a counter on the bus has no second track; allowed: false");
  encoder.finish();
  return e;
}

WheelConfig parse_wheel(Section& wheel, const WeightStock& stock) {
  WheelConfig w;
  w.name = kWheelNames[wheel.choice("name", wheel_name_list())];
  w.mass_kg = wheel.number("mass_kg", {1, 1000});
  w.mass_sigma_kg = wheel.number_or("mass_sigma_kg", {0, w.mass_kg}, kWheelMassDoubt * w.mass_kg);
  if (wheel.has("rotating_mass_kg")) w.rotating_mass_kg = wheel.number("rotating_mass_kg", {1, w.mass_kg});
  w.rolling_radius_m = wheel.number("rolling_radius_m", {0.05, 2});
  w.weight_radius_m = wheel.number("weight_radius_m", {0.02, 2});
  if (w.weight_radius_m >= w.rolling_radius_m)
    wheel.fail("weight_radius_m", "must be less than rolling_radius_m");
  parse_places(wheel, stock, w);
  w.node = wheel.text_or("node", "");
  w.line = static_cast<int>(wheel.integer_or("line", 0, kEncoderLines - 1, 0));
  if (auto encoder = wheel.section_if("encoder")) {
    w.encoder = parse_encoder(std::move(*encoder));
    if (w.node.empty()) wheel.fail("encoder", "needs the node that reads it; allowed: node = \"name\"");
  } else if (!w.node.empty()) {
    wheel.fail("encoder", "missing although a node reads it; allowed: a table [wheel.encoder]");
  }
  wheel.finish();
  return w;
}

/// The pulse counter that an encoder names must be the wheel's own.
void check_counter(const Section& section, const WheelConfig& wheel, const VehicleConfig& v) {
  if (wheel.encoder.counter.empty()) return;
  std::string names;
  for (const NodeConfig& node : v.node) {
    if (node.name != wheel.node) continue;
    for (const CanConfig& can : node.wiring.can)
      for (const SignalConfig& signal : can.signal) {
        if (signal.quantity != SignalQuantity::kPulseCounter || signal.wheel != wheel.name) continue;
        if (signal.name == wheel.encoder.counter) return;
        names += (names.empty() ? "" : ", ") + signal.name;
      }
  }
  section.fail("encoder", "node " + wheel.node + " receives no pulse_counter \"" + wheel.encoder.counter +
                              "\" of this wheel; allowed: " + (names.empty() ? "no counter" : names));
}

PlaneConfig parse_plane(Section plane) {
  PlaneConfig p;
  p.name = plane.text("name");
  const auto place = plane.numbers("position_m", 3, {-20, 20});
  p.position_m = {place[0], place[1], place[2]};
  p.weight_radius_m = plane.number("weight_radius_m", {0.005, 2});
  plane.finish();
  return p;
}

}  // namespace

std::vector<std::string> wheel_name_list() {
  return {kWheelNames.begin(), kWheelNames.end()};
}

void parse_wheels(Section& root, VehicleConfig& v) {
  std::set<std::string> seen;
  std::set<std::pair<std::string, int>> lines;
  const WeightStock stock = parse_stock(root);
  for (Section& section : root.sections("wheel", kWheels)) {
    const WheelConfig wheel = parse_wheel(section, stock);
    if (!seen.insert(wheel.name).second) section.fail("name", "\"" + wheel.name + "\" stands twice");
    if (!wheel.node.empty()) {
      const bool known =
          std::any_of(v.node.begin(), v.node.end(), [&](const auto& n) { return n.name == wheel.node; });
      std::string names;
      for (const auto& node : v.node) names += (names.empty() ? "" : ", ") + node.name;
      if (!known) section.fail("node", "there is no node \"" + wheel.node + "\"; allowed: " + names);
      if (!lines.insert({wheel.node, wheel.line}).second)
        section.fail(
            "line", "line " + std::to_string(wheel.line) + " of node " + wheel.node + " has a wheel already");
    }
    check_counter(section, wheel, v);
    const auto place = std::find(kWheelNames.begin(), kWheelNames.end(), wheel.name) - kWheelNames.begin();
    v.wheel[static_cast<std::size_t>(place)] = wheel;
  }
}

void parse_rotors(Section& root, VehicleConfig& v) {
  for (Section& section : root.sections("rotor")) {
    RotorConfig rotor;
    rotor.name = section.text("name");
    if (v.rotor_named(rotor.name) || v.wheel_named(rotor.name))
      section.fail("name", "\"" + rotor.name + "\" stands twice");
    for (const std::string& name : section.texts_or("wheel", {})) {
      const WheelConfig* const wheel = v.wheel_named(name);
      if (!wheel || wheel->node.empty())
        section.fail("wheel", "\"" + name + "\" is no wheel with an encoder");
      rotor.wheel.push_back(v.place_of(*wheel));
    }
    if (rotor.wheel.empty()) section.fail("wheel", "missing; allowed: the wheels that turn it, in [ ]");
    rotor.ratio = section.number("ratio", {1e-3, 1e3});
    for (Section& plane : section.sections("plane")) rotor.plane.push_back(parse_plane(std::move(plane)));
    section.finish();
    v.rotor.push_back(std::move(rotor));
  }
}

}  // namespace roadbalance
