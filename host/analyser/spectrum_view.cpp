#include "host/analyser/spectrum_view.hpp"

#include <algorithm>
#include <utility>

#include "host/analyser/shown_bins.hpp"

namespace roadbalance {
namespace {

void add_parts(SpectrumPart about, double highest_hz, const CrossSpectra& spectra,
               std::vector<SpectrumPart>& parts) {
  const ShownBins bins(spectra, highest_hz, SpectrumView::kMostShown);
  const std::vector<double> density = bins.of(about.held ? spectra.peak_density(0) : spectra.density(0));
  constexpr std::size_t kPerPart = kSpectrumBinsPerPart;
  about.parts = static_cast<std::int32_t>((density.size() + kPerPart - 1) / kPerPart);
  about.step_hz = bins.step_hz();
  about.enbw_hz = bins.enbw_hz();
  about.averages = spectra.averages();
  for (std::size_t first = 0; first < density.size(); first += kPerPart) {
    SpectrumPart& part = parts.emplace_back(about);
    part.part = static_cast<std::int32_t>(first / kPerPart);
    part.first_hz = bins.hz(first);
    for (std::size_t k = first; k < std::min(density.size(), first + kPerPart); ++k)
      part.density.push_back(static_cast<float>(density[k]));
  }
}

}  // namespace

void SpectrumView::take(const View& view, WallTime now) {
  forget(now);
  if (!viewers_.contains(view.viewer) && viewers_.size() >= kMostViewers) return;
  Viewer& viewer = viewers_[view.viewer];
  viewer.heard = now;
  const bool asked_anew = std::exchange(viewer.highest_hz, view.highest_hz) != view.highest_hz;
  std::vector<Wanted> before = std::exchange(viewer.wanted, {});
  for (const ChannelId& channel : view.spectrum) {
    Wanted wanted{channel,
                  {{channel}, view.segment, view.window, view.memory, view.hold_peaks, view.overlap}};
    const auto same = std::ranges::find(before, wanted.kind, &Wanted::kind);
    if (same != before.end() && !asked_anew) wanted.sent = same->sent;
    viewer.wanted.push_back(std::move(wanted));
  }
  forget(now);  // before more is begun
  for (Wanted& wanted : viewer.wanted)
    wanted.state = pool_.has(wanted.channel) ? pool_.begin(wanted.kind) : SpectralState::kNoChannel;
}

void SpectrumView::forget(WallTime now) {
  std::erase_if(viewers_, [&](const auto& viewer) { return now - viewer.second.heard > kForgotten; });
  pool_.keep_only([&](const Kind& kind) {
    return std::ranges::any_of(viewers_, [&](const auto& viewer) {
      return std::ranges::find(viewer.second.wanted, kind, &Wanted::kind) != viewer.second.wanted.end();
    });
  });
}

std::vector<SpectrumPart> SpectrumView::parts(WallTime now) {
  forget(now);
  std::vector<SpectrumPart> parts;
  for (auto& [id, viewer] : viewers_)
    for (Wanted& wanted : viewer.wanted) {
      const JointSpectra* const joint = pool_.find(wanted.kind);
      const int averages = joint ? joint->spectra().averages() : 0;
      const SpectralState state =
          wanted.state == SpectralState::kComputed && averages == 0 ? SpectralState::kTooShort : wanted.state;
      const std::pair now_sent(state, averages);
      if (std::exchange(wanted.sent, now_sent) == now_sent) continue;
      const SpectrumPart about{.viewer = id,
                               .node = wanted.channel.node,
                               .channel = wanted.channel.channel,
                               .state = state,
                               .time_ns = joint ? joint->end_ns() : 0,
                               .held = wanted.kind.hold_peaks};
      if (state != SpectralState::kComputed)
        parts.push_back(about);
      else
        add_parts(about, viewer.highest_hz, joint->spectra(), parts);
    }
  return parts;
}

}  // namespace roadbalance
