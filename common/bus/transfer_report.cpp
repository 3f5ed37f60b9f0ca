#include "common/bus/transfer_report.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <wire/transfer_t.hpp>
#include <wire/view_t.hpp>

#include "common/bus/wire_format.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/frontend/front_end.hpp"

namespace roadbalance {
namespace {

static_assert(sizeof(wire::view_t::input_node) / sizeof(std::int32_t) == kMostViewPairs);
static_assert(sizeof(wire::view_t::spectrum_node) / sizeof(std::int32_t) == kMostViewChannels);
static_assert(sizeof(wire::view_t::envelope_node) / sizeof(std::int32_t) == kMostViewChannels);
static_assert(sizeof(wire::view_t::waterfall_node) / sizeof(std::int32_t) == kMostViewWaterfalls);
static_assert(sizeof(wire::transfer_t::input) / sizeof(float) == kTransferBinsPerPart);

bool is_channel(std::int32_t channel) {
  return 0 <= channel && channel < kChannels;
}

bool is_wheel(std::int32_t wheel) {
  return 0 <= wheel && wheel < kWheels;
}

bool all_of(const std::int32_t* first, std::int32_t count, bool (*is)(std::int32_t)) {
  return std::all_of(first, first + count, is);
}

bool in_bounds(const wire::view_t& m) {
  const auto counts = [](std::int32_t count, std::size_t most) {
    return 0 <= count && count <= static_cast<std::int32_t>(most);
  };
  return kShortestSegment <= m.segment && m.segment <= kLongestSegment && 0 <= m.memory &&
         (m.hold_peaks == 0 || m.hold_peaks == 1) && 0.0 <= m.overlap && m.overlap <= 0.75 &&
         m.highest_hz > 0.0 && std::isfinite(m.highest_hz) && 0 <= m.window &&
         m.window <= static_cast<std::int32_t>(Window::kFlatTop) && counts(m.pairs, kMostViewPairs) &&
         counts(m.spectra, kMostViewChannels) && counts(m.envelopes, kMostViewChannels) &&
         counts(m.waterfalls, kMostViewWaterfalls) && all_of(m.input_channel, m.pairs, is_channel) &&
         all_of(m.output_channel, m.pairs, is_channel) && all_of(m.spectrum_channel, m.spectra, is_channel) &&
         all_of(m.envelope_channel, m.envelopes, is_channel) &&
         all_of(m.waterfall_channel, m.waterfalls, is_channel) &&
         all_of(m.waterfall_wheel, m.waterfalls, is_wheel);
}

void put(const std::vector<ChannelId>& from, std::int32_t* node, std::int32_t* channel) {
  for (std::size_t k = 0; k < from.size(); ++k) {
    node[k] = from[k].node;
    channel[k] = from[k].channel;
  }
}

}  // namespace

std::vector<std::uint8_t> encode(const View& view) {
  assert(view.pair.size() <= kMostViewPairs && view.spectrum.size() <= kMostViewChannels &&
         view.envelope.size() <= kMostViewChannels && view.waterfall.size() <= kMostViewWaterfalls);
  wire::view_t m{};
  m.viewer = view.viewer;
  m.segment = view.segment;
  m.window = static_cast<std::int32_t>(view.window);
  m.memory = view.memory;
  m.hold_peaks = view.hold_peaks ? 1 : 0;
  m.overlap = view.overlap;
  m.highest_hz = view.highest_hz;
  m.pairs = static_cast<std::int32_t>(view.pair.size());
  for (std::size_t k = 0; k < view.pair.size(); ++k) {
    m.input_node[k] = view.pair[k].input.node;
    m.input_channel[k] = view.pair[k].input.channel;
    m.output_node[k] = view.pair[k].output.node;
    m.output_channel[k] = view.pair[k].output.channel;
  }
  m.spectra = static_cast<std::int32_t>(view.spectrum.size());
  put(view.spectrum, m.spectrum_node, m.spectrum_channel);
  m.envelopes = static_cast<std::int32_t>(view.envelope.size());
  put(view.envelope, m.envelope_node, m.envelope_channel);
  m.waterfalls = static_cast<std::int32_t>(view.waterfall.size());
  for (std::size_t k = 0; k < view.waterfall.size(); ++k) {
    m.waterfall_wheel[k] = view.waterfall[k].wheel;
    m.waterfall_node[k] = view.waterfall[k].channel.node;
    m.waterfall_channel[k] = view.waterfall[k].channel.channel;
  }
  return wire_format::encode(m);
}

std::optional<View> decode_view(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::view_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  View view{.viewer = m->viewer,
            .segment = m->segment,
            .window = static_cast<Window>(m->window),
            .memory = m->memory,
            .hold_peaks = m->hold_peaks == 1,
            .overlap = m->overlap,
            .highest_hz = m->highest_hz};
  for (std::int32_t k = 0; k < m->pairs; ++k)
    view.pair.push_back({{m->input_node[k], m->input_channel[k]}, {m->output_node[k], m->output_channel[k]}});
  for (std::int32_t k = 0; k < m->spectra; ++k)
    view.spectrum.push_back({m->spectrum_node[k], m->spectrum_channel[k]});
  for (std::int32_t k = 0; k < m->envelopes; ++k)
    view.envelope.push_back({m->envelope_node[k], m->envelope_channel[k]});
  for (std::int32_t k = 0; k < m->waterfalls; ++k)
    view.waterfall.push_back({m->waterfall_wheel[k], {m->waterfall_node[k], m->waterfall_channel[k]}});
  return view;
}

std::vector<std::uint8_t> encode(const TransferPart& part) {
  assert(part.bin.size() <= kTransferBinsPerPart);
  wire::transfer_t m{};
  m.viewer = part.viewer;
  m.input_node = part.pair.input.node;
  m.input_channel = part.pair.input.channel;
  m.output_node = part.pair.output.node;
  m.output_channel = part.pair.output.channel;
  m.state = static_cast<std::int32_t>(part.state);
  m.time_ns = part.time_ns;
  m.part = part.part;
  m.parts = part.parts;
  m.bins = static_cast<std::int32_t>(part.bin.size());
  m.first_hz = part.first_hz;
  m.step_hz = part.step_hz;
  m.enbw_hz = part.enbw_hz;
  m.independent_averages = part.independent_averages;
  m.coherence_by_chance = part.coherence_by_chance;
  for (std::size_t k = 0; k < part.bin.size(); ++k) {
    const TransferPart::Bin& bin = part.bin[k];
    m.input[k] = bin.input;
    m.output[k] = bin.output;
    m.h1_re[k] = bin.h1_re;
    m.h1_im[k] = bin.h1_im;
    m.radius_95[k] = bin.radius_95;
    m.coherence[k] = bin.coherence;
  }
  return wire_format::encode(m);
}

std::optional<TransferPart> decode_transfer(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::transfer_t>(bytes);
  if (!m || m->bins < 0 || m->state < 0 || m->state > static_cast<std::int32_t>(TransferState::kTooMuch) ||
      m->bins > static_cast<std::int32_t>(kTransferBinsPerPart) || m->part < 0 || m->part >= m->parts ||
      !is_channel(m->input_channel) || !is_channel(m->output_channel))
    return std::nullopt;
  TransferPart part{.viewer = m->viewer,
                    .pair = {{m->input_node, m->input_channel}, {m->output_node, m->output_channel}},
                    .state = static_cast<TransferState>(m->state),
                    .time_ns = m->time_ns,
                    .part = m->part,
                    .parts = m->parts,
                    .first_hz = m->first_hz,
                    .step_hz = m->step_hz,
                    .enbw_hz = m->enbw_hz,
                    .independent_averages = m->independent_averages,
                    .coherence_by_chance = m->coherence_by_chance};
  for (std::int32_t k = 0; k < m->bins; ++k)
    part.bin.push_back(
        {m->input[k], m->output[k], m->h1_re[k], m->h1_im[k], m->radius_95[k], m->coherence[k]});
  return part;
}

}  // namespace roadbalance
