#include "host/excerpt/row_decimator.hpp"

#include <algorithm>
#include <cmath>

#include "common/dsp/decimation.hpp"
#include "common/link/angle_sigma.hpp"

namespace roadbalance {
std::int32_t worst_of(std::int32_t a, std::int32_t b) {
  std::int32_t both = (a | b) & kQualityFlags & ~kQualityAfterGap;
  for (int line = 0; line < kEncoderLines; ++line) {
    const int place = angle_sigma_place(line);
    const std::int32_t one = a >> place & kMostAngleSigma, other = b >> place & kMostAngleSigma;
    if (one != 0 && other != 0) both |= std::max(one, other) << place;  // 0: it is not told
  }
  return both;
}

RowDecimator::RowDecimator(int factor)
    : factor_(factor),
      taps_(reduction_taps(factor)),
      history_(kChannels, 4 * taps_.size()),
      beside_(static_cast<std::size_t>(history_.cols())) {}

QualifiedRow RowDecimator::filtered() const {
  const Eigen::Index n = taps_.size();
  const Eigen::Matrix<double, kChannels, 1> values = history_.middleCols(filled_ - n, n) * taps_;
  const auto begin = beside_.begin() + (filled_ - n);
  QualifiedRow row{.time_ns = (begin + (n - 1) / 2)->time_ns, .overload = 0, .quality = begin->quality};
  for (auto one = begin; one != begin + n; ++one) {
    row.overload |= one->overload;
    row.quality = worst_of(row.quality, one->quality);
  }
  for (std::size_t c = 0; c < row.counts.size(); ++c)
    row.counts[c] = static_cast<std::int32_t>(std::lround(values[static_cast<Eigen::Index>(c)]));
  for (int line = 0; line < kEncoderLines; ++line)
    if ((row.quality & quality_no_reference(line)) != 0)
      std::fill_n(row.counts.begin() + kAccelerations + 2 * line, 2, 0);
  return row;
}

std::optional<RowDecimator::Reduced> RowDecimator::add(const QualifiedRow& row, std::int64_t index) {
  const Eigen::Index n = taps_.size();
  if (index != next_index_) filled_ = 0;
  next_index_ = index + 1;
  if (filled_ == history_.cols()) {
    history_.leftCols(n - 1) = history_.rightCols(n - 1).eval();
    std::copy(beside_.end() - (n - 1), beside_.end(), beside_.begin());
    filled_ = n - 1;
  }
  history_.col(filled_) =
      Eigen::Map<const Eigen::Matrix<std::int32_t, kChannels, 1>>(row.counts.data()).cast<double>();
  beside_[static_cast<std::size_t>(filled_)] = {row.time_ns, row.overload, row.quality};
  ++filled_;
  const std::int64_t centre = index - (n - 1) / 2;
  if (filled_ < n || centre % factor_ != 0) return std::nullopt;
  return Reduced{filtered(), centre / factor_};
}

}  // namespace roadbalance
