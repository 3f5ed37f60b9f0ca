#include "firmware/backends/gpio/gpio_input.hpp"

#include <cmath>

#include "common/config/section.hpp"
#include "common/gpio/edge_limit.hpp"

namespace roadbalance {
namespace {

/// For an ordinary machine; `rb doctor` measures it.
constexpr WakeUps kUsual{.interrupt_thread = std::chrono::microseconds(50),
                         .reader = std::chrono::microseconds(800)};

using Warn = std::function<void(const std::string&)>;

void check_encoder(const std::string& where, const LineConfig& line, const WheelConfig& wheel,
                   const Warn& warn) {
  if (wheel.encoder.zero_mark && !line.zero_mark_gpio)
    warn(where + ": no zero_mark_gpio, so the angle of wheel " + wheel.name + " will never be known");
  if (!wheel.encoder.zero_mark && line.zero_mark_gpio)
    warn(where + ": zero_mark_gpio is not used, for wheel " + wheel.name + " says zero_mark = false");
  const double fastest_hz = (line.direction_gpio ? 2.0 : 1.0) * wheel.encoder.pulses_per_turn * kMostTurns_hz;
  if (fastest_hz > edge_limit_hz(kUsual))
    warn(where + ": the encoder of wheel " + wheel.name + " gives up to " +
         std::to_string(std::lround(fastest_hz / 1000.0)) + " kHz of edges, but GPIO loses some above " +
         std::to_string(std::lround(edge_limit_hz(kUsual) / 1000.0)) +
         " kHz on an ordinary machine (`rb doctor` measures this one); the USB board captures them in "
         "hardware");
}

}  // namespace

std::vector<GpioInput> gpio_inputs(const std::string& device, const VehicleConfig& vehicle,
                                   const NodeConfig& node, const Warn& warn) {
  if (node.wiring.line.empty())
    throw ConfigError("front end " + device + ": vehicle.toml has no [[node.line]] for node " + node.name +
                      ", so nothing is wired to it");
  std::vector<GpioInput> inputs;
  for (const LineConfig& line : node.wiring.line) {
    const std::string where = "[[node.line]] line " + std::to_string(line.line) + " of node " + node.name;
    const auto add = [&](int offset, GpioTrack track, const char* key) {
      inputs.push_back(
          {static_cast<unsigned>(offset), static_cast<std::uint8_t>(line.line), track, where + ": " + key});
    };
    add(line.tooth_gpio, GpioTrack::kTooth, "tooth_gpio");
    if (line.direction_gpio) add(*line.direction_gpio, GpioTrack::kDirection, "direction_gpio");
    if (line.zero_mark_gpio) add(*line.zero_mark_gpio, GpioTrack::kZeroMark, "zero_mark_gpio");
    if (const WheelConfig* const wheel = vehicle.wheel_at(node, line.line))
      check_encoder(where, line, *wheel, warn);
    else
      warn(where + ": no wheel has its encoder there, so nobody uses its edges");
  }
  for (int line = 0; line < kEncoderLines; ++line) {
    const WheelConfig* const wheel = vehicle.wheel_at(node, line);
    if (wheel && !node.wiring.line_at(line))
      warn("wheel " + wheel->name + " has its encoder on line " + std::to_string(line) + " of node " +
           node.name + ", which has no [[node.line]]: " + device + " gives it no edges");
  }
  return inputs;
}

}  // namespace roadbalance
