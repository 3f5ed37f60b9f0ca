#include "host/analysis/orders/order_waterfall.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace roadbalance {
namespace {

const OrderWaterfall::Settings& checked(const OrderWaterfall::Settings& s) {
  if (s.channels < 1 || s.rows_per_turn < 2 || s.turns < 1)
    throw std::invalid_argument("order spectrum: it needs channels, rows and turns");
  if (!(s.highest_order > 0.0 && s.highest_order <= 0.5 * s.rows_per_turn))
    throw std::invalid_argument("order spectrum: highest order must be within half the rows of a turn");
  if (!(s.highest_hz > 0.0 && s.class_hz > 0.0))
    throw std::invalid_argument("order spectrum: highest frequency and class width must be positive");
  return s;
}

}  // namespace

OrderWaterfall::OrderWaterfall(const Settings& settings)
    : settings_(checked(settings)),
      fft_(settings.turns * settings.rows_per_turn),
      window_(window(Window::kFlatTop, fft_.size())),
      scale_(2.0 / std::accumulate(window_.begin(), window_.end(), 0.0)),
      lines_(static_cast<Eigen::Index>(std::floor(settings.highest_order * settings.turns + 1e-9)) + 1),
      tapered_(window_.size()),
      transform_(static_cast<std::size_t>(fft_.bins())) {}

Eigen::Index OrderWaterfall::lines_of(int speed_class) const {
  const double highest_order = settings_.highest_hz / ((speed_class + 1) * settings_.class_hz);
  const double lines = std::floor(highest_order * settings_.turns + 1e-9) + 1.0;
  return lines < static_cast<double>(lines_) ? static_cast<Eigen::Index>(lines) : lines_;
}

void OrderWaterfall::add(const TurnBlock& block) {
  const double place = block.rotation_hz / settings_.class_hz;
  if (!(place < kMostClasses)) {
    ++too_fast_;
    return;
  }
  const int speed_class = static_cast<int>(place);
  const auto channels = static_cast<std::size_t>(settings_.channels);
  Sums& sums =
      classes_
          .try_emplace(speed_class, Sums{std::vector<int>(channels),
                                         Eigen::MatrixXd::Zero(lines_of(speed_class), settings_.channels)})
          .first->second;
  for (int c = 0; c < settings_.channels; ++c) {
    if ((block.overload >> c & 1U) != 0) continue;
    for (std::size_t n = 0; n < tapered_.size(); ++n)
      tapered_[n] = window_[n] * block.values(static_cast<Eigen::Index>(n), c);
    fft_.forward(tapered_, transform_);
    for (Eigen::Index k = 0; k < sums.squares.rows(); ++k)
      sums.squares(k, c) +=
          std::norm((k == 0 ? 0.5 : 1.0) * scale_ * transform_[static_cast<std::size_t>(k)]);
    ++sums.blocks[static_cast<std::size_t>(c)];
  }
}

OrderSpectrum OrderWaterfall::empty() const {
  const double step = 1.0 / settings_.turns;
  return {step, equivalent_noise_bandwidth_bins(window_) * step, {}, {}};
}

std::vector<OrderWaterfall::Row> OrderWaterfall::rows(int channel) const {
  std::vector<Row> rows;
  for (const auto& [speed_class, sums] : classes_) {
    const int blocks = sums.blocks[static_cast<std::size_t>(channel)];
    if (blocks == 0) continue;
    Row row{speed_class * settings_.class_hz, (speed_class + 1) * settings_.class_hz, empty()};
    for (Eigen::Index k = 0; k < sums.squares.rows(); ++k)
      row.spectrum.amplitude.push_back(std::sqrt(sums.squares(k, channel) / blocks));
    row.spectrum.averages.assign(row.spectrum.amplitude.size(), blocks);
    rows.push_back(std::move(row));
  }
  return rows;
}

OrderSpectrum OrderWaterfall::spectrum(int channel) const {
  OrderSpectrum whole = empty();
  for (const auto& [speed_class, sums] : classes_) {
    const int blocks = sums.blocks[static_cast<std::size_t>(channel)];
    if (blocks == 0) continue;
    const auto lines = static_cast<std::size_t>(sums.squares.rows());
    if (whole.amplitude.size() < lines) {
      whole.amplitude.resize(lines);
      whole.averages.resize(lines);
    }
    for (std::size_t k = 0; k < lines; ++k) {
      whole.amplitude[k] += sums.squares(static_cast<Eigen::Index>(k), channel);
      whole.averages[k] += blocks;
    }
  }
  for (std::size_t k = 0; k < whole.amplitude.size(); ++k)
    whole.amplitude[k] = std::sqrt(whole.amplitude[k] / whole.averages[k]);
  return whole;
}

}  // namespace roadbalance
