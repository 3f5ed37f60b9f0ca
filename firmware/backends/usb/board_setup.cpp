#include "firmware/backends/usb/board_setup.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

using board::Configuration;
using board::Identity;

constexpr double kMicrovoltsPerVolt = 1e6;

/// The names that checks need for the thing at fault.
struct Subject {
  const VehicleConfig& vehicle;
  const NodeConfig& node;
  const Identity& identity;

  [[noreturn]] void refuse(const std::string& key, const std::string& reason) const {
    throw ConfigError("vehicle " + vehicle.name + ": " + key + ": " + reason);
  }
  std::string node_key(const std::string& key) const { return "node " + node.name + ": " + key; }
};

std::string text_of(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::string version_of(const Identity& identity) {
  return std::to_string(identity.major) + "." + std::to_string(identity.minor);
}

const std::string kOurs = std::to_string(board::kProtocolMajor) + "." + std::to_string(board::kProtocolMinor);

std::uint32_t ticks_per_scan(const Subject& on) {
  const double ticks = on.identity.tick_hz / on.node.rate_hz;
  if (on.node.rate_hz < on.identity.rate_min_hz || on.node.rate_hz > on.identity.rate_max_hz)
    on.refuse(on.node_key("rate_hz"), text_of(on.node.rate_hz) + " cannot be had of the board; allowed: " +
                                          std::to_string(on.identity.rate_min_hz) + " to " +
                                          std::to_string(on.identity.rate_max_hz));
  if (ticks != std::round(ticks))
    on.refuse(on.node_key("rate_hz"), text_of(on.node.rate_hz) +
                                          " is no whole number of the board's ticks; allowed: divisors of " +
                                          std::to_string(on.identity.tick_hz));
  return static_cast<std::uint32_t>(ticks);
}

void set_filter(const Subject& on, Configuration& to) {
  const FilterConfig& filter = on.vehicle.filter;
  std::string orders;
  for (int order = 1; order < 32; ++order)
    if (on.identity.filter_orders >> order & 1)
      orders += (orders.empty() ? "" : ", ") + std::to_string(order);
  if (!(on.identity.filter_orders >> filter.order & 1))
    on.refuse("filter: order", std::to_string(filter.order) + " cannot be had of the board; allowed: " +
                                   (orders.empty() ? "nothing, it has no filter" : orders));
  const bool whole = filter.cutoff_hz == std::round(filter.cutoff_hz);
  if (!whole || filter.cutoff_hz < on.identity.filter_min_hz || filter.cutoff_hz > on.identity.filter_max_hz)
    on.refuse("filter: cutoff_hz", text_of(filter.cutoff_hz) +
                                       " cannot be had of the board; allowed: a whole number from " +
                                       std::to_string(on.identity.filter_min_hz) + " to " +
                                       std::to_string(on.identity.filter_max_hz));
  to.filter_order = static_cast<std::uint8_t>(filter.order);
  to.filter_corner_hz = static_cast<std::uint32_t>(filter.cutoff_hz);
}

std::uint8_t range_of(const Subject& on, const ChannelConfig& channel) {
  const auto& full_scale_uv = on.identity.full_scale_uv;
  if (!channel.input_range_v)
    return static_cast<std::uint8_t>(std::ranges::max_element(full_scale_uv) - full_scale_uv.begin());
  std::string ranges;
  for (std::size_t k = 0; k < board::kRanges; ++k) {
    if (std::llround(*channel.input_range_v * kMicrovoltsPerVolt) == full_scale_uv[k])
      return static_cast<std::uint8_t>(k);
    ranges += (k == 0 ? "" : ", ") + text_of(full_scale_uv[k] / kMicrovoltsPerVolt);
  }
  on.refuse(on.node_key("channel " + channel.name + ": input_range_v"),
            text_of(*channel.input_range_v) + " cannot be had of the board; allowed: " + ranges);
}

void set_ranges(const Subject& on, std::size_t which, std::size_t boards, Configuration& to) {
  const std::size_t inputs = boards == 1 ? board::kInputChannels : kInputsOfPair;
  for (std::size_t input = 0; input < inputs; ++input) {
    const std::size_t channel = which * inputs + input;
    if (channel < on.node.channel.size()) to.range[input] = range_of(on, on.node.channel[channel]);
  }
}

/// The wheel whose encoder is wired to this line of the board; nullptr: none.
const WheelConfig* wheel_at_board(const Subject& on, int line) {
  return on.node.wiring.line_at(line) ? nullptr : on.vehicle.wheel_at(on.node, line);
}

board::EncoderSetup encoder_of(const Subject& on, const WheelConfig& wheel) {
  const std::string key = "wheel " + wheel.name + ": encoder: ";
  if (wheel.encoder.pulses_per_turn < 4 || wheel.encoder.pulses_per_turn > UINT16_MAX)
    on.refuse(key + "pulses_per_turn", std::to_string(wheel.encoder.pulses_per_turn) +
                                           " cannot be had of the board; allowed: 4 to 65535");
  if (wheel.encoder.quadrature && !(on.identity.capabilities & board::kHasQuadrature))
    on.refuse(key + "quadrature", "the board does not decode a second track; allowed: false");
  const int flags =
      (wheel.encoder.zero_mark ? board::kZeroWired : 0) | (wheel.encoder.quadrature ? board::kQuadrature : 0);
  return {static_cast<std::uint16_t>(wheel.encoder.pulses_per_turn), static_cast<std::uint16_t>(flags)};
}

std::int32_t datum_of(const WheelConfig& wheel) {
  const double turns = wheel.encoder.datum_rad / (2.0 * std::numbers::pi);
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(std::llround(turns * 4294967296.0)));
}

}  // namespace

std::string protocol_refusal(const Identity& identity) {
  if (identity.major == board::kProtocolMajor) return "";
  return "the board speaks protocol " + version_of(identity) + ", this node " + kOurs + "; " +
         (identity.major > board::kProtocolMajor ? "a newer rb-node" : "newer firmware of the board") +
         " is needed";
}

std::string protocol_note(const Identity& identity) {
  if (identity.minor <= board::kProtocolMinor) return "";
  return "the board speaks protocol " + version_of(identity) + ", this node " + kOurs +
         "; what is new in it is not used";
}

BoardSetup board_setup(const VehicleConfig& vehicle, const NodeConfig& node, const Identity& identity,
                       std::size_t which, std::size_t boards) {
  const Subject on{vehicle, node, identity};
  BoardSetup setup;
  setup.configuration.ticks_per_scan = ticks_per_scan(on);
  set_filter(on, setup.configuration);
  set_ranges(on, which, boards, setup.configuration);
  if (boards > 1 && !(identity.capabilities & board::kHasSync))
    on.refuse(on.node_key("front_end"),
              "two boards need the SYNC connector, which one has not; allowed: one");
  if (which > 0) return setup;
  if (node.wiring.loop_back && !(identity.capabilities & board::kHasReferences))
    on.refuse(on.node_key("loop_back"), "the board gives no references; allowed: false");
  setup.configuration.references_on = node.wiring.loop_back ? 1 : 0;
  for (int line = 0; line < kEncoderLines; ++line) {
    const auto k = static_cast<std::size_t>(line);
    const WheelConfig* wheel = wheel_at_board(on, line);
    if (!wheel && node.wiring.loop_back && vehicle.wheel_at(node, line))
      on.refuse(on.node_key("loop_back"), "the encoder of line " + std::to_string(line) +
                                              " is not wired to the board, which makes the reference of it; "
                                              "allowed: false");
    if (!wheel) continue;
    setup.configuration.encoder[k] = encoder_of(on, *wheel);
    if (node.wiring.loop_back)
      setup.references.wheel[k] = {.on = 1,
                                   .line = static_cast<std::uint8_t>(line),
                                   .amplitude_per_mille = kReferencePerMille,
                                   .datum = datum_of(*wheel)};
  }
  return setup;
}

}  // namespace roadbalance
