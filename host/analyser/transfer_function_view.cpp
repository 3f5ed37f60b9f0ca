#include "host/analyser/transfer_function_view.hpp"

#include <algorithm>
#include <utility>

#include "common/dsp/transfer_function.hpp"
#include "host/analyser/shown_bins.hpp"

namespace roadbalance {
namespace {

bool same(const View& a, const View& b) {
  return a.highest_hz == b.highest_hz &&
         std::ranges::equal(a.pair, b.pair, [](const ChannelPair& one, const ChannelPair& other) {
           return one.input == other.input && one.output == other.output;
         });
}

/// Parts of one pair.
void add_bins(const TransferFunctionPart& about, double highest_hz, const CrossSpectra& spectra, int input,
              int output, std::vector<TransferFunctionPart>& parts) {
  const ShownBins bins(spectra, highest_hz, TransferFunctionView::kMostShown);
  const auto in = bins.of(spectra.density(input)), out = bins.of(spectra.density(output));
  const double averages = spectra.independent_averages() * bins.worth();
  const TransferFunction h = transfer_function(in, out, bins.of(spectra.density(input, output)), averages);
  const std::size_t count = (h.h1.size() + kTransferFunctionBinsPerPart - 1) / kTransferFunctionBinsPerPart;
  for (std::size_t first = 0; first < h.h1.size(); first += kTransferFunctionBinsPerPart) {
    TransferFunctionPart& part = parts.emplace_back(about);
    part.part = static_cast<std::int32_t>(first / kTransferFunctionBinsPerPart);
    part.parts = static_cast<std::int32_t>(count);
    part.step_hz = bins.step_hz();
    part.enbw_hz = bins.enbw_hz();
    part.independent_averages = averages;
    part.coherence_by_chance = h.coherence_by_chance;
    part.first_hz = bins.hz(first);
    for (std::size_t k = first; k < std::min(h.h1.size(), first + kTransferFunctionBinsPerPart); ++k)
      part.bin.push_back({static_cast<float>(in[k]), static_cast<float>(out[k]),
                          static_cast<float>(h.h1[k].real()), static_cast<float>(h.h1[k].imag()),
                          static_cast<float>(h.radius_95[k]), static_cast<float>(h.coherence[k])});
  }
}

}  // namespace

/// The channels of its pairs that there are, each once, in order.
TransferFunctionView::Kind TransferFunctionView::kind_of(const View& view) const {
  std::vector<ChannelId> channels;
  for (const ChannelPair& pair : view.pair)
    if (pool_.has(pair.input) && pool_.has(pair.output)) {
      channels.push_back(pair.input);
      channels.push_back(pair.output);
    }
  std::ranges::sort(channels);
  channels.erase(std::unique(channels.begin(), channels.end()), channels.end());
  return {channels, view.segment, view.window, view.memory, false, view.overlap};
}

void TransferFunctionView::take(const View& view, WallTime now) {
  forget(now);
  const auto known = viewers_.find(view.viewer);
  if (known == viewers_.end() && viewers_.size() >= kMostViewers) return;
  const Kind kind = kind_of(view);
  Viewer& viewer = viewers_[view.viewer];
  viewer.heard = now;
  if (known != viewers_.end() && viewer.kind == kind && same(viewer.view, view)) {
    if (viewer.state == SpectralState::kTooMuch) viewer.state = pool_.begin(kind);  // others may have left
    return;
  }
  viewer.view = view;
  viewer.kind = kind;
  viewer.sent = -1;  // what is asked for anew is sent at once
  forget(now);
  viewer.state = pool_.begin(kind);
}

void TransferFunctionView::forget(WallTime now) {
  std::erase_if(viewers_, [&](const auto& viewer) { return now - viewer.second.heard > kForgotten; });
  pool_.keep_only([&](const Kind& kind) {
    return std::ranges::any_of(viewers_, [&](const auto& viewer) { return viewer.second.kind == kind; });
  });
}

std::vector<TransferFunctionPart> TransferFunctionView::parts(WallTime now) {
  forget(now);
  std::vector<TransferFunctionPart> parts;
  for (auto& [id, viewer] : viewers_) {
    if (viewer.view.pair.empty()) continue;
    const JointSpectra* const joint = pool_.find(viewer.kind);
    const SpectralState state = joint ? state_of(*joint) : viewer.state;
    const int averages = joint ? joint->spectra().averages() : 0;
    const int news = averages > 0 ? averages : -1 - static_cast<int>(state);
    if (std::exchange(viewer.sent, news) != news) add_pairs(viewer, state, joint, parts);
  }
  return parts;
}

void TransferFunctionView::add_pairs(const Viewer& viewer, SpectralState state, const JointSpectra* joint,
                                     std::vector<TransferFunctionPart>& parts) const {
  const auto& channels = viewer.kind.channel;
  const auto index_of = [&](const ChannelId& id) {
    const auto found = std::ranges::lower_bound(channels, id);
    return found != channels.end() && *found == id ? static_cast<int>(found - channels.begin()) : -1;
  };
  for (const ChannelPair& pair : viewer.view.pair) {
    const int input = index_of(pair.input), output = index_of(pair.output);
    TransferFunctionPart about{.viewer = viewer.view.viewer, .pair = pair, .state = state};
    if (input < 0 || output < 0) about.state = SpectralState::kNoChannel;
    if (about.state != SpectralState::kComputed || !joint) {
      parts.push_back(about);
      continue;
    }
    about.time_ns = joint->end_ns();
    add_bins(about, viewer.view.highest_hz, joint->spectra(), input, output, parts);
  }
}

}  // namespace roadbalance
