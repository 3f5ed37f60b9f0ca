#include "host/analysis/spectra/spectra.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace roadbalance {
namespace {

int segment_samples(const NodeConfig& node) {
  return std::max(2, static_cast<int>(std::lround(SpectrumMeter::kSegment_s * node.rate_hz)));
}

}  // namespace

SpectrumMeter::SpectrumMeter(const NodeConfig& node)
    : node_(node),
      psd_({.rate_hz = node.rate_hz, .segment = segment_samples(node), .overlap = 0.0}),
      segment_(segment_samples(node)),
      hop_(std::max<std::int64_t>(1, segment_ / 2)),
      bins_(std::min(static_cast<std::size_t>(segment_ / 2) + 1,
                     static_cast<std::size_t>(kHighest_hz / psd_.step_hz()) + 1)),
      counts_(node.channel.size(), std::vector<std::int32_t>(static_cast<std::size_t>(segment_))),
      samples_(static_cast<std::size_t>(segment_)) {}

void SpectrumMeter::add(const ScanBlock& block) {
  const BlockHeader& header = block.header;
  std::int64_t row = 0;
  if (header.epoch != epoch_ || header.first_scan != next_scan_) {
    densities_.clear();
    filled_ = 0;
    news_ = false;  // what has not been taken was of them
  }
  epoch_ = header.epoch;
  next_scan_ = header.first_scan + header.scans;
  // A segment begins where all of them may.
  if (filled_ == 0) row = (hop_ - header.first_scan % hop_) % hop_;
  while (row < header.scans) {
    const std::int64_t count = std::min(header.scans - row, segment_ - filled_);
    take_rows(block, row, count);
    row += count;
    if (filled_ < segment_) continue;
    end_ns_ = block.row_time_ns(row);
    add_segment();
  }
}

void SpectrumMeter::take_rows(const ScanBlock& block, std::int64_t first, std::int64_t count) {
  for (std::size_t c = 0; c < counts_.size(); ++c) {
    std::int32_t* const to = counts_[c].data() + filled_;
    for (std::int64_t row = 0; row < count; ++row)
      to[row] = block.counts[static_cast<std::size_t>(first + row)][c];
  }
  filled_ += count;
}

void SpectrumMeter::add_segment() {
  constexpr auto kSegments = static_cast<std::size_t>(2.0 * kHistory_s / kSegment_s) - 1;  // half overlapping
  std::vector<double> densities;
  if (densities_.size() == kSegments) {
    densities = std::move(densities_.front());
    densities_.pop_front();
    densities.clear();
  }
  for (std::size_t c = 0; c < counts_.size(); ++c) {
    auto& counts = counts_[c];
    const auto to_si = [&channel = node_.channel[c]](std::int32_t count) { return channel.to_si(count); };
    std::ranges::transform(counts, samples_.begin(), to_si);
    psd_.reset();
    psd_.add(samples_);
    const std::vector<double> density = psd_.density();
    densities.insert(densities.end(), density.begin(), density.begin() + static_cast<std::ptrdiff_t>(bins_));
    std::copy(counts.begin() + static_cast<std::ptrdiff_t>(hop_), counts.end(), counts.begin());
  }
  densities_.push_back(std::move(densities));
  filled_ = segment_ - hop_;
  news_ = true;
}

std::vector<SpectrumPart> SpectrumMeter::take() {
  std::vector<SpectrumPart> parts;
  if (!std::exchange(news_, false)) return parts;
  for (std::size_t c = 0; c < counts_.size(); ++c) append_parts(static_cast<std::int32_t>(c), parts);
  return parts;
}

void SpectrumMeter::append_parts(std::int32_t channel, std::vector<SpectrumPart>& parts) const {
  std::vector<double> density(bins_);
  for (const std::vector<double>& one : densities_)
    for (std::size_t bin = 0; bin < bins_; ++bin)
      density[bin] += one[static_cast<std::size_t>(channel) * bins_ + bin];
  for (double& mean : density) mean /= static_cast<double>(densities_.size());
  constexpr std::size_t kPerPart = kSpectrumBinsPerPart;
  for (std::size_t first = 0; first < bins_; first += kPerPart) {
    SpectrumPart& part = parts.emplace_back();
    part.node = node_.id;
    part.channel = channel;
    part.time_ns = end_ns_;
    part.part = static_cast<std::int32_t>(first / kPerPart);
    part.parts = static_cast<std::int32_t>((bins_ + kPerPart - 1) / kPerPart);
    part.first_hz = static_cast<double>(first) * psd_.step_hz();
    part.step_hz = psd_.step_hz();
    part.enbw_hz = psd_.enbw_hz();
    part.averages = static_cast<std::int32_t>(densities_.size());
    for (std::size_t bin = first; bin < std::min(bins_, first + kPerPart); ++bin)
      part.density.push_back(static_cast<float>(density[bin]));
  }
}

}  // namespace roadbalance
