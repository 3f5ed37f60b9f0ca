#include "host/analyser/transfer_view.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "common/bus/codec.hpp"
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

}  // namespace

TransferView::TransferView(const VehicleConfig& vehicle) : vehicle_(vehicle) {
  std::vector<double> rates;
  for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
    const NodeConfig& node = vehicle.node[n];
    const auto found = std::find(rates.begin(), rates.end(), node.rate_hz);
    const auto rate = static_cast<std::size_t>(found - rates.begin());
    if (found == rates.end()) {
      rates.push_back(node.rate_hz);
      rate_.emplace_back();
    }
    for (std::size_t c = 0; c < node.channel.size(); ++c) {
      if (node.channel[c].role == ChannelRole::kUnused) continue;
      place_[{node.id, static_cast<std::int32_t>(c)}] = {rate, static_cast<int>(rate_[rate].size())};
      rate_[rate].push_back({static_cast<int>(n), static_cast<int>(c)});
    }
  }
}

const TransferView::Place* TransferView::place_of(const ChannelId& id) const {
  const auto found = place_.find(id);
  return found == place_.end() ? nullptr : &found->second;
}

void TransferView::take(const View& view, WallTime now) {
  forget(now);
  const Kind kind{view.segment, view.window, view.memory, view.overlap};
  if (!kinds_.contains(kind)) {
    if (kinds_.size() >= kMostKinds) return;
    Spectra& spectra = kinds_[kind];
    for (const auto& channels : rate_)
      spectra.of_rate.push_back(
          channels.empty() ? nullptr
                           : std::make_unique<JointSpectra>(vehicle_, channels,
                                                            JointSpectra::Settings{.segment = view.segment,
                                                                                   .overlap = view.overlap,
                                                                                   .window = view.window,
                                                                                   .memory = view.memory}));
  }
  const auto known = viewers_.find(view.viewer);
  if (known == viewers_.end() && viewers_.size() >= kMostViewers) return;
  Viewer& viewer = viewers_[view.viewer];
  const auto same_pairs = [](const View& a, const View& b) {
    return std::ranges::equal(a.pair, b.pair, [](const ChannelPair& one, const ChannelPair& other) {
      return one.input == other.input && one.output == other.output;
    });
  };
  const bool same = viewer.view.segment == view.segment && viewer.view.window == view.window &&
                    viewer.view.memory == view.memory && viewer.view.overlap == view.overlap &&
                    viewer.view.highest_hz == view.highest_hz && same_pairs(viewer.view, view);
  if (!same) viewer.told.clear();  // what is asked for anew is told at once
  viewer.view = view;
  viewer.heard = now;
}

void TransferView::forget(WallTime now) {
  std::erase_if(viewers_, [&](const auto& viewer) { return now - viewer.second.heard > kForgotten; });
  std::erase_if(kinds_, [&](const auto& kind) {
    return std::none_of(viewers_.begin(), viewers_.end(), [&](const auto& viewer) {
      const View& view = viewer.second.view;
      return kind.first == Kind{view.segment, view.window, view.memory, view.overlap};
    });
  });
}

void TransferView::consume(const SealedBlock& block) {
  if (block.kind != BlockKind::kScan) return;
  newest_ns_ = std::max(newest_ns_, block.header.time_ns);
  for (auto& [kind, spectra] : kinds_)
    for (auto& joint : spectra.of_rate)
      if (joint) joint->consume(block);
}

void TransferView::consume(const ClockFit& fit) {
  for (auto& [kind, spectra] : kinds_)
    for (auto& joint : spectra.of_rate)
      if (joint) joint->consume(fit);
}

std::vector<TransferPart> TransferView::parts(WallTime now) {
  forget(now);
  std::vector<TransferPart> parts;
  for (auto& [id, viewer] : viewers_) {
    const View& view = viewer.view;
    const auto kind = kinds_.find(Kind{view.segment, view.window, view.memory, view.overlap});
    if (kind == kinds_.end()) continue;
    for (std::size_t rate = 0; rate < rate_.size(); ++rate) {
      if (!kind->second.of_rate[rate]) continue;
      const CrossSpectra& spectra = kind->second.of_rate[rate]->spectra();
      int& told = viewer.told[rate];
      if (spectra.averages() == told) continue;
      told = spectra.averages();
      for (const ChannelPair& pair : view.pair) {
        const Place *const input = place_of(pair.input), *const output = place_of(pair.output);
        if (input && output && input->rate == rate && output->rate == rate)
          add_pair(viewer, pair, spectra, input->channel, output->channel, parts);
      }
    }
  }
  return parts;
}

void TransferView::add_pair(const Viewer& viewer, const ChannelPair& pair, const CrossSpectra& spectra,
                            int input, int output, std::vector<TransferPart>& parts) const {
  const double highest = std::floor(viewer.view.highest_hz / spectra.step_hz() + 1e-9) + 1.0;
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
    TransferPart part{.viewer = viewer.view.viewer,
                      .pair = pair,
                      .time_ns = newest_ns_,
                      .part = static_cast<std::int32_t>(first / kTransferBinsPerPart),
                      .parts = static_cast<std::int32_t>(count),
                      .step_hz = merged * spectra.step_hz(),
                      .enbw_hz = spectra.enbw_hz() * std::max(1.0, merged / widths),
                      .independent_averages = averages,
                      .coherence_by_chance = h.coherence_by_chance};
    // The middle of those that are shown as one.
    part.first_hz = (static_cast<double>(first) + 0.5 * (1.0 - 1.0 / merged)) * part.step_hz;
    for (std::size_t k = first; k < std::min(h.h1.size(), first + kTransferBinsPerPart); ++k)
      part.bin.push_back({static_cast<float>(show.input[k]), static_cast<float>(show.output[k]),
                          static_cast<float>(h.h1[k].real()), static_cast<float>(h.h1[k].imag()),
                          static_cast<float>(h.radius_95[k]), static_cast<float>(h.coherence[k])});
    parts.push_back(part);
  }
}

}  // namespace roadbalance
