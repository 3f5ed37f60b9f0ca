#include "common/config/vehicle_config.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/config/parse_balancing.hpp"
#include "common/config/section.hpp"
#include "common/config/text_file.hpp"
#include "common/types/angle_units.hpp"
#include "common/types/block.hpp"

namespace roadbalance {
namespace {

std::vector<std::string> wheel_name_list() {
  return {kWheelNames.begin(), kWheelNames.end()};
}

EncoderConfig parse_encoder(Section encoder) {
  EncoderConfig e;
  e.pulses_per_turn = static_cast<int>(encoder.integer("pulses_per_turn", 1, 100'000));
  e.zero_mark = encoder.boolean_or("zero_mark", true);
  e.quadrature = encoder.boolean_or("quadrature", false);
  e.datum_rad = kDegree * encoder.number_or("datum_deg", {-360, 360}, 0.0);
  e.datum_sigma_rad = kDegree * encoder.number_or("datum_sigma_deg", {0, 180}, 0.0);
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
  w.mass_sigma_kg = wheel.number_or("mass_sigma_kg", {0, w.mass_kg}, kWheelMassSigma * w.mass_kg);
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

PlaneConfig parse_rotor_plane(Section plane) {
  PlaneConfig p;
  p.name = plane.text("name");
  const auto place = plane.numbers("position_m", 3, {-20, 20});
  p.position_m = {place[0], place[1], place[2]};
  p.weight_radius_m = plane.number("weight_radius_m", {0.005, 2});
  plane.finish();
  return p;
}

/// [[wheel]] of vehicle.toml.
/// @param v  its nodes are known
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

/// [[rotor]].
/// @param v  its wheels are known
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
    for (Section& plane : section.sections("plane"))
      rotor.plane.push_back(parse_rotor_plane(std::move(plane)));
    section.finish();
    v.rotor.push_back(std::move(rotor));
  }
}

AxleConfig parse_axle(Section axle) {
  AxleConfig a{};
  a.x_m = axle.number("x_m", {-10, 10});
  a.half_track_m = axle.number("half_track_m", {0.2, 3});
  a.spring_n_m = axle.number("spring_n_m", kPositive);
  a.damper_n_s_m = axle.number("damper_n_s_m", kPositive);
  a.stabiliser_n_m = axle.number("stabiliser_n_m", kNotNegative);
  a.tyre_n_m = axle.number("tyre_n_m", kPositive);
  a.tyre_damper_n_s_m = axle.number_or("tyre_damper_n_s_m", kNotNegative, 0.0);
  a.tyre_damper_sigma_n_s_m = axle.number_or("tyre_damper_sigma_n_s_m", kNotNegative, kTyreDamperSigma_n_s_m);
  axle.finish();
  return a;
}

ModelConfig parse_model(Section model) {
  ModelConfig m{};
  if (model.choice("kind", {"seven_dof", "description"}) == 1) {
    m.description = model.text("file");
    model.finish();
    return m;
  }
  m.body_mass_kg = model.number("body_mass_kg", kPositive);
  m.roll_inertia_kg_m2 = model.number("roll_inertia_kg_m2", kPositive);
  m.pitch_inertia_kg_m2 = model.number("pitch_inertia_kg_m2", kPositive);
  const auto sigma = [&](const char* key, double value, double share) {
    return model.number_or(key, {0, value}, share * value);
  };
  m.body_mass_sigma_kg = sigma("body_mass_sigma_kg", m.body_mass_kg, kBodyMassSigma);
  m.roll_inertia_sigma_kg_m2 = sigma("roll_inertia_sigma_kg_m2", m.roll_inertia_kg_m2, kInertiaSigma);
  m.pitch_inertia_sigma_kg_m2 = sigma("pitch_inertia_sigma_kg_m2", m.pitch_inertia_kg_m2, kInertiaSigma);
  m.axle = {parse_axle(model.section("front")), parse_axle(model.section("rear"))};
  if (m.axle[1].x_m >= m.axle[0].x_m)
    model.fail("rear", "x_m of the rear axle must be less than the front's");
  model.finish();
  return m;
}

bool has_road_channel(const VehicleConfig& vehicle, const std::string& wheel) {
  for (const NodeConfig& node : vehicle.node)
    for (const ChannelConfig& channel : node.channel)
      if (channel.role == ChannelRole::kRoad && channel.mount == wheel) return true;
  return false;
}

ChannelConfig parse_channel(Section channel) {
  ChannelConfig c;
  c.name = channel.text("name");
  constexpr std::array kRoles{ChannelRole::kAcceleration, ChannelRole::kRoad, ChannelRole::kUnused};
  c.role = kRoles[channel.choice_or("role", {"acceleration", "road", "unused"}, 0)];
  auto mounts = wheel_name_list();
  mounts.emplace_back("body");
  mounts.emplace_back("elsewhere");
  const bool used = c.role != ChannelRole::kUnused;
  c.mount =
      mounts[used ? channel.choice("mount", mounts) : channel.choice_or("mount", mounts, mounts.size() - 1)];
  const auto place = channel.numbers_or("position_m", 3, {-20, 20}, {0, 0, 0});
  if (c.mount == "body" && !channel.has("position_m"))
    channel.fail("position_m", "missing; allowed: 3 numbers in [ ], metres from the body's centre of mass");
  const auto direction = channel.numbers_or("direction", 3, {-1, 1}, {0, 0, 1});
  c.position_m = {place[0], place[1], place[2]};
  c.direction = {direction[0], direction[1], direction[2]};
  if (c.direction.norm() < 0.5)
    channel.fail("direction", "is no direction; allowed: a unit vector, 3 numbers in [ ]");
  c.direction.normalize();
  c.range_m_s2 = channel.number("range_m_s2", {1e-6, 1e6});
  c.scale_m_s2_per_count = c.range_m_s2 / kFullScaleCounts;
  if (channel.has("input_range_v")) c.input_range_v = channel.number("input_range_v", {1e-3, 1e3});
  c.gain_sigma = channel.number_or("gain_sigma", {0, 0.5}, c.gain_sigma);
  if (auto calibration = channel.section_if("calibration")) {
    c.scale_m_s2_per_count = calibration->number("scale_m_s2_per_count", {1e-12, 1e3});
    c.offset_counts = calibration->number_or("offset_counts", {-kFullScaleCounts, kFullScaleCounts}, 0.0);
    c.delay_s = 1e-6 * calibration->number_or("delay_us", {-10'000, 10'000}, 0.0);
    calibration->finish();
  }
  channel.finish();
  return c;
}

NodeConfig parse_node(Section& node) {
  NodeConfig n;
  n.name = node.text("name");
  if (n.name.empty() ||
      n.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos)
    node.fail("name", "allowed: lower-case letters, digits and _");
  n.id = static_cast<int>(node.integer("id", 1, kLastNode));
  n.rate_hz = node.number("rate_hz", {1, 100'000});
  std::set<std::string> names;
  for (Section& channel : node.sections("channel", 1)) {
    n.channel.push_back(parse_channel(std::move(channel)));
    if (!names.insert(n.channel.back().name).second)
      node.fail("channel", "name \"" + n.channel.back().name + "\" stands twice");
  }
  if (n.channel.size() > kAccelerations)
    node.fail("channel", "has " + std::to_string(n.channel.size()) + " channels; allowed: at most 12");
  n.wiring = NodeWiring::take(node, wheel_name_list());
  node.finish();
  return n;
}

DriveConfig parse_drive(Section drive, double rate_hz) {
  DriveConfig d;
  d.identification_rate_hz =
      drive.number_or("identification_rate_hz", {50, 10'000}, d.identification_rate_hz);
  d.section_s = drive.number_or("section_s", {4, 120}, d.section_s);
  d.speed_class_m_s = drive.number_or("speed_class_m_s", {0.1, 20}, d.speed_class_m_s);
  d.least_speed_m_s = drive.number_or("least_speed_m_s", {1, 100}, d.least_speed_m_s);
  // A slower recording can be looked at, but not identified from; identification reports that.
  const double factor = rate_hz / d.identification_rate_hz;
  if (factor >= 1.0 && std::abs(factor - std::round(factor)) > 1e-9)
    drive.fail("identification_rate_hz", "must divide the nodes' rate_hz");
  drive.finish();
  return d;
}

void parse_nodes(Section& root, VehicleConfig& v) {
  std::set<std::string> names;
  std::set<int> ids;
  std::size_t channels = 0;
  for (Section& section : root.sections("node", 1)) {
    v.node.push_back(parse_node(section));
    const NodeConfig& node = v.node.back();
    channels += node.channel.size();
    if (channels > VehicleConfig::kMostChannels)
      section.fail("channel", "more than " + std::to_string(VehicleConfig::kMostChannels) + " in all nodes");
    if (!names.insert(node.name).second) section.fail("name", "\"" + node.name + "\" stands twice");
    if (!ids.insert(node.id).second) section.fail("id", std::to_string(node.id) + " stands twice");
    if (node.rate_hz != v.node.front().rate_hz) section.fail("rate_hz", "must be the same for all nodes");
    if (v.filter.cutoff_hz >= node.rate_hz / 2)
      section.fail("rate_hz", "must be more than twice the filter's cutoff_hz");
  }
}

}  // namespace

VehicleConfig VehicleConfig::parse(const std::string& text, const std::string& name_for_errors) {
  Section root = Section::parse_text(text, name_for_errors);
  VehicleConfig v;
  v.text = text;
  v.name = root.text("name");
  v.model = parse_model(root.section("model"));
  if (auto filter = root.section_if("filter")) {
    filter->choice_or("kind", {"butterworth"}, 0);
    v.filter.order = static_cast<int>(filter->integer_or("order", 1, 12, v.filter.order));
    v.filter.cutoff_hz = filter->number_or("cutoff_hz", {0.1, 1e5}, v.filter.cutoff_hz);
    filter->finish();
  }
  parse_nodes(root, v);
  parse_wheels(root, v);
  parse_rotors(root, v);
  v.limits = parse_limits(root);
  v.seat = parse_seats(root);
  if (auto road = root.section_if("road")) {
    v.road.measured = road->boolean_or("measured", false);
    for (const char* wheel : kWheelNames)
      if (v.road.measured && !has_road_channel(v, wheel))
        road->fail("measured",
                   std::string("no channel of role road has mount ") + wheel + "; allowed: false");
    road->finish();
  }
  auto drive = root.section_if("drive");
  v.drive = parse_drive(drive ? std::move(*drive) : Section::parse_text("", name_for_errors),
                        v.node.front().rate_hz);
  root.finish();
  return v;
}

VehicleConfig VehicleConfig::read_file(const std::string& path) {
  VehicleConfig vehicle = parse(read_text_file(path, Section::kMostBytes), path);
  vehicle.folder = std::filesystem::path(path).parent_path().string();
  return vehicle;
}

const NodeConfig& VehicleConfig::node_named(const std::string& node_name) const {
  std::string names;
  for (const auto& candidate : node) {
    if (candidate.name == node_name) return candidate;
    names += (names.empty() ? "" : ", ") + candidate.name;
  }
  throw ConfigError("there is no node \"" + node_name + "\" in vehicle " + name + "; allowed: " + names);
}

const NodeConfig* VehicleConfig::node_with_id(int id) const {
  const auto found = std::find_if(node.begin(), node.end(), [&](const auto& n) { return n.id == id; });
  return found == node.end() ? nullptr : &*found;
}

const WheelConfig* VehicleConfig::wheel_named(const std::string& wheel_name) const {
  const auto found = std::ranges::find(wheel, wheel_name, &WheelConfig::name);
  return found == wheel.end() ? nullptr : &*found;
}

const RotorConfig* VehicleConfig::rotor_named(const std::string& rotor_name) const {
  const auto found = std::ranges::find(rotor, rotor_name, &RotorConfig::name);
  return found == rotor.end() ? nullptr : &*found;
}

const WheelConfig* VehicleConfig::wheel_at(const NodeConfig& at, int line) const {
  const auto is_read = [&](const WheelConfig& one) { return one.node == at.name && one.line == line; };
  const auto found = std::ranges::find_if(wheel, is_read);
  return found == wheel.end() ? nullptr : &*found;
}

}  // namespace roadbalance
