#include "host/analyser/spectra.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace roadbalance {
namespace {

int segment_samples(const NodeConfig& node) {
  return std::max(2, static_cast<int>(std::lround(SpectrumMeter::kSegment_s * node.rate_hz)));
}

}  // namespace

SpectrumMeter::SpectrumMeter(const NodeConfig& node)
    : node_(node),
      psd_({.rate_hz = node.rate_hz, .segment = segment_samples(node)}),
      segment_(static_cast<std::size_t>(segment_samples(node))),
      keep_(static_cast<std::size_t>(std::lround(kHistory_s * node.rate_hz))),
      history_(node.channel.size()) {}

void SpectrumMeter::add(const ScanBlock& block) {
  if (block.header.epoch != epoch_ || block.header.first_scan != next_scan_)
    for (auto& samples : history_) samples.clear();
  epoch_ = block.header.epoch;
  next_scan_ = block.header.first_scan + block.header.scans;
  end_ns_ = block.row_time_ns(block.header.scans);
  news_ = true;
  for (std::size_t c = 0; c < history_.size(); ++c) {
    auto& samples = history_[c];
    for (std::int64_t row = 0; row < block.header.scans; ++row)
      samples.push_back(node_.channel[c].to_si(block.counts[static_cast<std::size_t>(row)][c]));
    // Seldom, so that each sample is moved about once.
    if (samples.size() > 2 * keep_)
      samples.erase(samples.begin(), samples.end() - static_cast<std::ptrdiff_t>(keep_));
  }
}

std::vector<SpectrumPart> SpectrumMeter::take() {
  std::vector<SpectrumPart> parts;
  if (!news_) return parts;
  news_ = false;
  for (std::size_t c = 0; c < history_.size(); ++c) {
    const std::span<const double> samples(history_[c]);
    if (samples.size() < segment_) continue;
    psd_.reset();
    psd_.add(samples.last(std::min(samples.size(), keep_)));
    append_parts(static_cast<std::int32_t>(c), parts);
  }
  return parts;
}

void SpectrumMeter::append_parts(std::int32_t channel, std::vector<SpectrumPart>& parts) const {
  const std::vector<double> density = psd_.density();
  const auto highest = static_cast<std::size_t>(kHighest_hz / psd_.step_hz()) + 1;
  const std::size_t bins = std::min(density.size(), highest);
  constexpr std::size_t kPerPart = kSpectrumBinsPerPart;
  for (std::size_t first = 0; first < bins; first += kPerPart) {
    SpectrumPart& part = parts.emplace_back();
    part.node = node_.id;
    part.channel = channel;
    part.time_ns = end_ns_;
    part.part = static_cast<std::int32_t>(first / kPerPart);
    part.parts = static_cast<std::int32_t>((bins + kPerPart - 1) / kPerPart);
    part.first_hz = static_cast<double>(first) * psd_.step_hz();
    part.step_hz = psd_.step_hz();
    part.enbw_hz = psd_.enbw_hz();
    part.averages = psd_.averages();
    for (std::size_t bin = first; bin < std::min(bins, first + kPerPart); ++bin)
      part.density.push_back(static_cast<float>(density[bin]));
  }
}

}  // namespace roadbalance
