#include "host/analysis/identify/resampler.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace roadbalance {
namespace {

constexpr double kJump = 0.5;  // periods

}  // namespace

void Resampler::add(const ScanBlock& block, double position, double spacing, bool follows, const Grid& grid,
                    std::vector<GridRows>& out) {
  const bool jumps =
      filled_ > 0 &&
      std::abs(position - sample_[static_cast<std::size_t>(filled_ - 1)].position - spacing) >= kJump;
  if (!follows || jumps) reset();
  for (std::int64_t row = 0; row < block.header.scans; ++row)
    push(block, row, position + static_cast<double>(row) * spacing);
  emit(grid, out);
}

void Resampler::push(const ScanBlock& block, std::int64_t row, double position) {
  if (filled_ == 0) {
    at_ = FractionalDelay::kBefore;
    restart_ = true;
  }
  if (filled_ == kCapacity) {
    // All rows but those that need the newest samples are out: at_ is near the end.
    const Eigen::Index gone = at_ - FractionalDelay::kBefore, kept = filled_ - gone;
    counts_.leftCols(kept) = counts_.middleCols(gone, kept).eval();
    std::copy_n(sample_.begin() + gone, kept, sample_.begin());
    filled_ = kept;
    at_ -= gone;
  }
  const auto& counts = block.counts[static_cast<std::size_t>(row)];
  counts_.col(filled_) =
      Eigen::Map<const Eigen::Matrix<std::int32_t, kChannels, 1>>(counts.data()).cast<double>();
  sample_[static_cast<std::size_t>(filled_)] = {position, block.overload, block.quality};
  if (filled_ == at_ && restart_) next_ = static_cast<std::int64_t>(std::ceil(position));
  ++filled_;
}

void Resampler::emit(const Grid& grid, std::vector<GridRows>& out) {
  const auto sample = [this](Eigen::Index i) -> const Sample& {
    return sample_[static_cast<std::size_t>(i)];
  };
  GridRows* rows = nullptr;
  for (;; ++next_) {
    while (at_ + 1 < filled_ && sample(at_ + 1).position <= static_cast<double>(next_)) ++at_;
    if (at_ + FractionalDelay::kAfter >= filled_) return;
    if (!rows || rows->rows == static_cast<std::int64_t>(GridRows::kMost)) {
      rows = &out.emplace_back();
      rows->first_index = next_;
      rows->time_ns = grid.time_ns(next_);
      rows->restart = std::exchange(restart_, false);
    }
    const Eigen::Index first = at_ - FractionalDelay::kBefore;
    const double from = sample(at_).position;
    const auto taps = delay_.taps((static_cast<double>(next_) - from) / (sample(at_ + 1).position - from));
    Eigen::Map<Eigen::Matrix<float, kChannels, 1>>(
        rows->counts[static_cast<std::size_t>(rows->rows)].data()) =
        (counts_.middleCols<FractionalDelay::kTaps>(first) * taps).cast<float>();
    for (Eigen::Index i = first; i < first + FractionalDelay::kTaps; ++i) {
      rows->overload |= sample(i).overload;
      rows->quality |= sample(i).quality & kQualityFlags;
    }
    ++rows->rows;
  }
}

}  // namespace roadbalance
