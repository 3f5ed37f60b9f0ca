#include "host/analysis/identify/channel_aligner.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {

ChannelDelays delays_of(const NodeConfig& node) {
  ChannelDelays delays{};
  for (std::size_t c = 0; c < node.channel.size(); ++c) delays[c] = node.channel[c].delay_s;
  return delays;
}

/// A run begins: its rate counts until the next.
void ChannelAligner::begin(const ScanBlock& block) {
  static const FractionalDelay kDelay;
  rows_.clear();
  delayed_.clear();
  before_ = behind_ = 0;
  for (std::size_t c = 0; c < delays_.size(); ++c) {
    if (delays_[c] == 0.0) continue;
    const double samples = delays_[c] * 1e12 / static_cast<double>(block.period_ps);
    const auto whole = static_cast<std::int64_t>(std::floor(samples));
    delayed_.push_back({c, whole, kDelay.taps(samples - static_cast<double>(whole))});
    before_ = std::max(before_, FractionalDelay::kBefore - whole);
    behind_ = std::max(behind_, FractionalDelay::kAfter + whole);
  }
  next_ = before_;
}

void ChannelAligner::add(const ScanBlock& block, const Emit& emit) {
  if (std::ranges::all_of(delays_, [](double delay) { return delay == 0.0; })) return emit(block);
  if (block.header.epoch != epoch_ || block.header.first_scan != next_scan_) begin(block);
  epoch_ = block.header.epoch;
  next_scan_ = block.header.first_scan + block.header.scans;
  for (std::int64_t r = 0; r < block.header.scans; ++r)
    rows_.push_back({block.counts[static_cast<std::size_t>(r)], block.header.first_scan + r,
                     block.row_time_ns(r), block.overload, block.quality});
  ScanBlock out;
  out.header = block.header;
  out.header.scans = 0;
  out.period_ps = block.period_ps;
  for (; next_ + behind_ < std::ssize(rows_) && out.header.scans < kScansPerBlock; ++next_) fill(out, next_);
  for (; next_ > before_; --next_) rows_.pop_front();
  if (out.header.scans > 0) emit(out);
}

void ChannelAligner::fill(ScanBlock& out, std::int64_t row) const {
  const Row& here = rows_[static_cast<std::size_t>(row)];
  if (out.header.scans == 0) {
    out.header.first_scan = here.scan;
    out.header.time_ns = here.time_ns;
  }
  auto& counts = out.counts[static_cast<std::size_t>(out.header.scans++)];
  counts = here.counts;
  for (const Delayed& one : delayed_) {
    double sum = 0.0;
    const std::int64_t first = row + one.whole - FractionalDelay::kBefore;
    for (int k = 0; k < FractionalDelay::kTaps; ++k)
      sum += one.taps(k) * rows_[static_cast<std::size_t>(first + k)].counts[one.channel];
    counts[one.channel] = static_cast<std::int32_t>(std::lround(sum));
  }
  for (std::int64_t k = row - before_; k <= row + behind_; ++k) {
    out.overload |= rows_[static_cast<std::size_t>(k)].overload;
    out.quality |= rows_[static_cast<std::size_t>(k)].quality & kQualityFlags;
  }
}

}  // namespace roadbalance
