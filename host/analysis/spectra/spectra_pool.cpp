#include "host/analysis/spectra/spectra_pool.hpp"

#include <algorithm>
#include <numeric>

namespace roadbalance {

SpectraPool::SpectraPool(const VehicleConfig& vehicle, const Limits& limits)
    : vehicle_(vehicle), limits_(limits) {
  for (std::size_t n = 0; n < vehicle.node.size(); ++n)
    for (std::size_t c = 0; c < vehicle.node[n].channel.size(); ++c)
      if (vehicle.node[n].channel[c].role != ChannelRole::kUnused)
        place_[{vehicle.node[n].id, static_cast<std::int32_t>(c)}] = {static_cast<int>(n),
                                                                      static_cast<int>(c)};
}

std::size_t SpectraPool::bytes(const Kind& kind) {
  return CrossSpectra::bytes(static_cast<int>(kind.channel.size()), kind.segment);
}

SpectralState SpectraPool::begin(const Kind& kind) {
  if (kind.channel.empty()) return SpectralState::kNoChannel;
  if (spectra_.contains(kind)) return SpectralState::kComputed;
  const std::size_t held =
      std::accumulate(spectra_.begin(), spectra_.end(), std::size_t{0},
                      [](std::size_t sum, const auto& one) { return sum + bytes(one.first); });
  if (spectra_.size() >= limits_.most || bytes(kind) > limits_.most_bytes ||
      held + bytes(kind) > limits_.most_bytes_all)
    return SpectralState::kTooMuch;
  std::vector<ChannelPlace> places;
  for (const ChannelId& id : kind.channel) places.push_back(place_.at(id));
  auto& joint = spectra_[kind];
  joint = std::make_unique<JointSpectra>(vehicle_, places,
                                         JointSpectra::Settings{.segment = kind.segment,
                                                                .overlap = kind.overlap,
                                                                .window = kind.window,
                                                                .memory = kind.memory,
                                                                .hold_peaks = kind.hold_peaks});
  for (const auto& [node, fit] : newest_fit_) joint->consume(fit);
  return SpectralState::kComputed;
}

const JointSpectra* SpectraPool::find(const Kind& kind) const {
  const auto found = spectra_.find(kind);
  return found == spectra_.end() ? nullptr : found->second.get();
}

void SpectraPool::keep_only(const std::function<bool(const Kind&)>& wanted) {
  std::erase_if(spectra_, [&](const auto& one) { return !wanted(one.first); });
}

void SpectraPool::consume(const SealedBlock& block) {
  if (block.kind != BlockKind::kScan) return;
  for (auto& [kind, joint] : spectra_) joint->consume(block);
}

void SpectraPool::consume(const ClockFit& fit) {
  if (!vehicle_.node_with_id(fit.node)) return;
  newest_fit_.insert_or_assign(fit.node, fit);
  for (auto& [kind, joint] : spectra_) joint->consume(fit);
}

SpectralState state_of(const JointSpectra& spectra) {
  if (spectra.spectra().averages() > 0) return SpectralState::kComputed;
  return spectra.refusal().empty() ? SpectralState::kTooShort : SpectralState::kNoCommonTime;
}

}  // namespace roadbalance
