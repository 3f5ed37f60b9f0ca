#include "host/analysis/orders/angle_resampler.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "common/dsp/decimation.hpp"
#include "common/dsp/weighted_sum.hpp"

namespace roadbalance {
namespace {

int decimation_of(const AngleSampler::Settings& settings) {
  if (settings.rows_per_turn < 1)
    throw std::invalid_argument("order analysis: rows per turn must be positive");
  const double factor = settings.rate_hz / (settings.rows_per_turn * settings.least_rotation_hz);
  if (!(factor < 1e4)) throw std::invalid_argument("order analysis: the least rotation is too slow");
  return std::max(1, static_cast<int>(std::ceil(factor)));
}

AngleSampler::Settings dense(AngleSampler::Settings settings, int factor) {
  settings.rows_per_turn *= factor;
  return settings;
}

}  // namespace

AngleResampler::AngleResampler(const AngleSampler::Settings& settings, AngleSampler::Emit emit)
    : rows_per_turn_(settings.rows_per_turn),
      factor_(decimation_of(settings)),
      taps_(decimation_taps(factor_)),
      history_(settings.channels, 8 * taps_.size()),
      place_(static_cast<std::size_t>(history_.cols())),
      emit_(std::move(emit)),
      sampler_(dense(settings, factor_), [this](const AngleRow& row) { take(row); }) {
  out_.values.resize(settings.channels);
}

double AngleResampler::highest_order() const {
  return kDecimationFlatTo * rows_per_turn_;
}

void AngleResampler::take(const AngleRow& row) {
  if (factor_ == 1) return emit_(row);
  if (row.restart) {
    filled_ = 0;
    restart_ = true;
  }
  const Eigen::Index n = taps_.size();
  if (filled_ == history_.cols()) {
    history_.leftCols(n - 1) = history_.rightCols(n - 1).eval();
    std::copy(place_.end() - (n - 1), place_.end(), place_.begin());
    filled_ = n - 1;
  }
  history_.col(filled_) = row.values;
  place_[static_cast<std::size_t>(filled_)] = {row.time_s, row.overload};
  ++filled_;
  const std::int64_t centre = row.index - (n - 1) / 2;
  if (filled_ < n || centre % factor_ != 0) return;
  out_.index = centre / factor_;
  out_.restart = std::exchange(restart_, false);
  out_.time_s = place_[static_cast<std::size_t>(filled_ - 1 - (n - 1) / 2)].time_s;
  out_.overload = 0;
  for (Eigen::Index i = filled_ - n; i < filled_; ++i)
    out_.overload |= place_[static_cast<std::size_t>(i)].overload;
  weighted_sum(history_.middleCols(filled_ - n, n), taps_, out_.values);
  emit_(out_);
}

}  // namespace roadbalance
