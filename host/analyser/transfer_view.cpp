#include "host/analyser/transfer_view.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "common/dsp/transfer_function.hpp"

namespace roadbalance {
namespace {

/// Neighbouring bins averaged into one.
struct Shown {
  std::vector<double> input, output;
  std::vector<std::complex<double>> cross;
  std::size_t merged = 1;
};

Shown shown(const std::vector<double>& input, const std::vector<double>& output,
            const std::vector<std::complex<double>>& cross, std::size_t bins) {
  Shown result;
  result.merged = (bins + TransferView::kMostShown - 1) / TransferView::kMostShown;
  const auto share = 1.0 / static_cast<double>(result.merged);
  for (std::size_t first = 0; first + result.merged <= bins; first += result.merged) {
    double in = 0.0, out = 0.0;
    std::complex<double> both = 0.0;
    for (std::size_t k = first; k < first + result.merged; ++k) {
      in += share * input[k];
      out += share * output[k];
      both += share * cross[k];
    }
    result.input.push_back(in), result.output.push_back(out), result.cross.push_back(both);
  }
  return result;
}

bool same(const View& a, const View& b) {
  return a.highest_hz == b.highest_hz &&
         std::ranges::equal(a.pair, b.pair, [](const ChannelPair& one, const ChannelPair& other) {
           return one.input == other.input && one.output == other.output;
         });
}

/// Parts of one pair.
void add_bins(const TransferPart& about, double highest_hz, const CrossSpectra& spectra, int input,
              int output, std::vector<TransferPart>& parts) {
  const double highest = std::floor(highest_hz / spectra.step_hz() + 1e-9) + 1.0;
  const auto bins = static_cast<std::size_t>(std::min(highest, static_cast<double>(spectra.bins())));
  const Shown show =
      shown(spectra.density(input), spectra.density(output), spectra.density(input, output), bins);
  const auto merged = static_cast<double>(show.merged);
  // Bins of a window that is wider than one share what they say.
  const double widths = std::max(1.0, spectra.enbw_hz() / spectra.step_hz());
  const double averages = spectra.independent_averages() * std::max(1.0, merged / widths);
  const TransferFunction h = transfer_function(show.input, show.output, show.cross, averages);
  const std::size_t count = (h.h1.size() + kTransferBinsPerPart - 1) / kTransferBinsPerPart;
  for (std::size_t first = 0; first < h.h1.size(); first += kTransferBinsPerPart) {
    TransferPart& part = parts.emplace_back(about);
    part.part = static_cast<std::int32_t>(first / kTransferBinsPerPart);
    part.parts = static_cast<std::int32_t>(count);
    part.step_hz = merged * spectra.step_hz();
    part.enbw_hz = spectra.enbw_hz() * std::max(1.0, merged / widths);
    part.independent_averages = averages;
    part.coherence_by_chance = h.coherence_by_chance;
    // The middle of those that are shown as one.
    part.first_hz = (static_cast<double>(first) + 0.5 * (1.0 - 1.0 / merged)) * part.step_hz;
    for (std::size_t k = first; k < std::min(h.h1.size(), first + kTransferBinsPerPart); ++k)
      part.bin.push_back({static_cast<float>(show.input[k]), static_cast<float>(show.output[k]),
                          static_cast<float>(h.h1[k].real()), static_cast<float>(h.h1[k].imag()),
                          static_cast<float>(h.radius_95[k]), static_cast<float>(h.coherence[k])});
  }
}

}  // namespace

TransferView::TransferView(const VehicleConfig& vehicle) : vehicle_(vehicle) {
  for (std::size_t n = 0; n < vehicle.node.size(); ++n)
    for (std::size_t c = 0; c < vehicle.node[n].channel.size(); ++c)
      if (vehicle.node[n].channel[c].role != ChannelRole::kUnused)
        place_[{vehicle.node[n].id, static_cast<std::int32_t>(c)}] = {static_cast<int>(n),
                                                                      static_cast<int>(c)};
}

/// The channels of its pairs that there are, each once, in order.
TransferView::Kind TransferView::kind_of(const View& view) const {
  std::vector<ChannelId> channels;
  for (const ChannelPair& pair : view.pair)
    if (place_.contains(pair.input) && place_.contains(pair.output)) {
      channels.push_back(pair.input);
      channels.push_back(pair.output);
    }
  std::ranges::sort(channels);
  channels.erase(std::ranges::unique(channels).begin(), channels.end());
  return {channels, view.segment, view.window, view.memory, view.overlap};
}

void TransferView::take(const View& view, WallTime now) {
  forget(now);
  const auto known = viewers_.find(view.viewer);
  if (known == viewers_.end() && viewers_.size() >= kMostViewers) return;
  const Kind kind = kind_of(view);
  Viewer& viewer = viewers_[view.viewer];
  viewer.heard = now;
  if (known != viewers_.end() && viewer.kind == kind && same(viewer.view, view)) {
    if (viewer.state == TransferState::kTooMuch) viewer.state = begin(kind);  // others may have left
    return;
  }
  viewer.view = view;
  viewer.kind = kind;
  viewer.told = -1;  // what is asked for anew is told at once
  forget(now);
  viewer.state = begin(kind);
}

TransferState TransferView::begin(const Kind& kind) {
  const auto& [channels, segment, window, memory, overlap] = kind;
  if (channels.empty()) return TransferState::kNoChannel;
  if (spectra_.contains(kind)) return TransferState::kTold;
  if (spectra_.size() >= kMostSpectra ||
      CrossSpectra::bytes(static_cast<int>(channels.size()), segment) > kMostBytes)
    return TransferState::kTooMuch;
  std::vector<ChannelPlace> places;
  for (const ChannelId& id : channels) places.push_back(place_.at(id));
  auto& joint = spectra_[kind];
  joint = std::make_unique<JointSpectra>(
      vehicle_, places,
      JointSpectra::Settings{.segment = segment, .overlap = overlap, .window = window, .memory = memory});
  for (const auto& [node, fit] : newest_fit_) joint->consume(fit);
  return TransferState::kTold;
}

void TransferView::forget(WallTime now) {
  std::erase_if(viewers_, [&](const auto& viewer) { return now - viewer.second.heard > kForgotten; });
  std::erase_if(spectra_, [&](const auto& one) {
    return std::ranges::none_of(viewers_,
                                [&](const auto& viewer) { return viewer.second.kind == one.first; });
  });
}

void TransferView::consume(const SealedBlock& block) {
  if (block.kind != BlockKind::kScan) return;
  for (auto& [kind, joint] : spectra_) joint->consume(block);
}

void TransferView::consume(const ClockFit& fit) {
  const bool ours = std::ranges::any_of(vehicle_.node, [&](const auto& node) { return node.id == fit.node; });
  if (!ours) return;
  newest_fit_.insert_or_assign(fit.node, fit);
  for (auto& [kind, joint] : spectra_) joint->consume(fit);
}

std::vector<TransferPart> TransferView::parts(WallTime now) {
  forget(now);
  std::vector<TransferPart> parts;
  for (auto& [id, viewer] : viewers_) {
    const auto found = spectra_.find(viewer.kind);
    const JointSpectra* const joint = found == spectra_.end() ? nullptr : found->second.get();
    TransferState state = viewer.state;
    int news = -1 - static_cast<int>(state);
    if (joint) {
      const int averages = joint->spectra().averages();
      if (averages > 0) {
        state = TransferState::kTold;
        news = averages;
      } else {
        state = joint->obstacle().empty() ? TransferState::kTooShort : TransferState::kNoCommonTime;
        news = -1 - static_cast<int>(state);
      }
    }
    if (std::exchange(viewer.told, news) != news) add_pairs(viewer, state, joint, parts);
  }
  return parts;
}

void TransferView::add_pairs(const Viewer& viewer, TransferState state, const JointSpectra* joint,
                             std::vector<TransferPart>& parts) const {
  const auto& channels = std::get<0>(viewer.kind);
  const auto index_of = [&](const ChannelId& id) {
    const auto found = std::ranges::lower_bound(channels, id);
    return found != channels.end() && *found == id ? static_cast<int>(found - channels.begin()) : -1;
  };
  for (const ChannelPair& pair : viewer.view.pair) {
    const int input = index_of(pair.input), output = index_of(pair.output);
    TransferPart about{.viewer = viewer.view.viewer, .pair = pair, .state = state};
    if (input < 0 || output < 0) about.state = TransferState::kNoChannel;
    if (about.state != TransferState::kTold || !joint) {
      parts.push_back(about);
      continue;
    }
    about.time_ns = joint->end_ns();
    add_bins(about, viewer.view.highest_hz, joint->spectra(), input, output, parts);
  }
}

}  // namespace roadbalance
