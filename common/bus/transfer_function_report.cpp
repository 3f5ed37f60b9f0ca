#include "common/bus/transfer_function_report.hpp"

#include <wire/transfer_t.hpp>
#include <wire/view_t.hpp>

#include "common/bus/fields.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<View> {
  using Wire = wire::view_t;
  static void list(auto& field, auto& view, auto& m) {
    field(view.viewer, m.viewer);
    field(view.segment, m.segment, within(kShortestSegment, kLongestSegment));
    field(view.window, m.window, up_to(Window::kFlatTop));
    field(view.memory, m.memory, at_least(0));
    field(view.hold_peaks, m.hold_peaks, up_to(1));
    field(view.overlap, m.overlap, within(0.0, 0.75));
    field(view.highest_hz, m.highest_hz, [](double highest) { return is_finite(highest) && highest > 0.0; });
    field.rows(view.pair, m.pairs, kMostViewPairs, [&](auto& pair, std::size_t k) {
      field(pair.input.node, m.input_node[k]);
      field(pair.input.channel, m.input_channel[k], below(kChannels));
      field(pair.output.node, m.output_node[k]);
      field(pair.output.channel, m.output_channel[k], below(kChannels));
    });
    field.rows(view.spectrum, m.spectra, kMostViewChannels, [&](auto& channel, std::size_t k) {
      field(channel.node, m.spectrum_node[k]);
      field(channel.channel, m.spectrum_channel[k], below(kChannels));
    });
    field.rows(view.envelope, m.envelopes, kMostViewChannels, [&](auto& channel, std::size_t k) {
      field(channel.node, m.envelope_node[k]);
      field(channel.channel, m.envelope_channel[k], below(kChannels));
    });
    field.rows(view.waterfall, m.waterfalls, kMostViewWaterfalls, [&](auto& of, std::size_t k) {
      field(of.wheel, m.waterfall_wheel[k], below(kWheels));
      field(of.channel.node, m.waterfall_node[k]);
      field(of.channel.channel, m.waterfall_channel[k], below(kChannels));
    });
  }
};

template <>
struct Fields<TransferFunctionPart> {
  using Wire = wire::transfer_t;
  static void list(auto& field, auto& part, auto& m) {
    field(part.viewer, m.viewer);
    field(part.pair.input.node, m.input_node);
    field(part.pair.input.channel, m.input_channel, below(kChannels));
    field(part.pair.output.node, m.output_node);
    field(part.pair.output.channel, m.output_channel, below(kChannels));
    field(part.state, m.state, up_to(SpectralState::kTooMuch));
    field(part.time_ns, m.time_ns);
    field(part.parts, m.parts);
    field(part.part, m.part, below(m.parts));
    field(part.first_hz, m.first_hz);
    field(part.step_hz, m.step_hz);
    field(part.enbw_hz, m.enbw_hz);
    field(part.independent_averages, m.independent_averages);
    field(part.coherence_by_chance, m.coherence_by_chance);
    field.rows(part.bin, m.bins, kTransferFunctionBinsPerPart, [&](auto& bin, std::size_t k) {
      field(bin.input, m.input[k]);
      field(bin.output, m.output[k]);
      field(bin.h1_re, m.h1_re[k]);
      field(bin.h1_im, m.h1_im[k]);
      field(bin.radius_95, m.radius_95[k]);
      field(bin.coherence, m.coherence[k]);
    });
  }
};

}  // namespace wire_fields

static_assert(sizeof(wire::view_t::input_node) / sizeof(std::int32_t) == kMostViewPairs);
static_assert(sizeof(wire::view_t::spectrum_node) / sizeof(std::int32_t) == kMostViewChannels);
static_assert(sizeof(wire::view_t::envelope_node) / sizeof(std::int32_t) == kMostViewChannels);
static_assert(sizeof(wire::view_t::waterfall_node) / sizeof(std::int32_t) == kMostViewWaterfalls);
static_assert(sizeof(wire::transfer_t::input) / sizeof(float) == kTransferFunctionBinsPerPart);

std::vector<std::uint8_t> encode(const View& message) {
  return wire_fields::encode(message);
}
std::vector<std::uint8_t> encode(const TransferFunctionPart& message) {
  return wire_fields::encode(message);
}
std::optional<View> decode_view(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<View>(bytes);
}
std::optional<TransferFunctionPart> decode_transfer_function(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<TransferFunctionPart>(bytes);
}

}  // namespace roadbalance
