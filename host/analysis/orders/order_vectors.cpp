#include "host/analysis/orders/order_vectors.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <string>

namespace roadbalance {
namespace {

const OrderVectors::Settings& checked(const OrderVectors::Settings& s) {
  if (s.channels < 1 || s.rows_per_turn < 2 || s.turns < 1)
    throw std::invalid_argument("order vectors: they need channels, rows and turns");
  if (!(s.highest_hz > 0.0 && s.class_hz > 0.0))
    throw std::invalid_argument("order vectors: highest frequency and class width must be positive");
  const double apart = (1.0 - 1e-9) / s.turns;
  for (std::size_t i = 0; i < s.order.size(); ++i) {
    if (!(s.order[i] >= apart && s.order[i] < 0.5 * s.rows_per_turn))
      throw std::invalid_argument(
          "order " + std::to_string(s.order[i]) +
          ": must be at least one period in a block and below half the rows of a turn");
    for (std::size_t k = 0; k < i; ++k)
      if (std::abs(s.order[i] - s.order[k]) < apart)
        throw std::invalid_argument("order " + std::to_string(s.order[i]) +
                                    ": too near another to be told apart within a block");
  }
  return s;
}

/// Least squares with x = mean + sum of Re X cos(h alpha) - Im X sin(h alpha).
Eigen::MatrixXd least_squares(const OrderVectors::Settings& s) {
  const Eigen::Index rows = s.turns * s.rows_per_turn, orders = std::ssize(s.order);
  Eigen::MatrixXd shape(rows, 2 * orders + 1);
  for (Eigen::Index n = 0; n < rows; ++n) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(n) / s.rows_per_turn;
    for (Eigen::Index i = 0; i < orders; ++i) {
      shape(n, 2 * i) = std::cos(s.order[static_cast<std::size_t>(i)] * angle);
      shape(n, 2 * i + 1) = -std::sin(s.order[static_cast<std::size_t>(i)] * angle);
    }
    shape(n, 2 * orders) = 1.0;
  }
  const Eigen::MatrixXd normal = shape.transpose() * shape;
  return normal.ldlt().solve(shape.transpose()).topRows(2 * orders);
}

}  // namespace

OrderVectors::OrderVectors(const Settings& settings)
    : settings_(checked(settings)),
      fit_(least_squares(settings_)),
      accumulator_(static_cast<std::size_t>(settings.channels) * settings.order.size()) {}

void OrderVectors::add(const TurnBlock& block) {
  const Eigen::MatrixXd fitted = fit_ * block.values;  // [2 order + re, im x channel]
  for (std::size_t i = 0; i < settings_.order.size(); ++i) {
    const double order = settings_.order[i];
    if (order * block.rotation_hz > settings_.highest_hz) continue;
    std::complex<double> recorded = 1.0;
    if (settings_.as_recorded) recorded = settings_.as_recorded(order, block.rotation_hz);
    // From the angle at the block's beginning to the angle since the run's; nothing for a whole order.
    const double turns = order * static_cast<double>(block.first_turn);
    recorded *= std::polar(1.0, 2.0 * std::numbers::pi * (turns - std::floor(turns)));
    for (int c = 0; c < settings_.channels; ++c) {
      if ((block.overload >> c & 1U) != 0) continue;
      const auto row = static_cast<Eigen::Index>(2 * i);
      const std::complex<double> vector(fitted(row, c), fitted(row + 1, c));
      add(block, i, vector / recorded,
          accumulator_[static_cast<std::size_t>(c) * settings_.order.size() + i]);
    }
  }
}

void OrderVectors::add(const TurnBlock& block, std::size_t order, std::complex<double> vector,
                       Accumulator& to) const {
  if (!has_phase(order) && block.run != to.current.run) {
    if (to.current.all.count() > to.best.all.count()) to.best = std::move(to.current);
    to.current = {};
  }
  to.current.run = block.run;
  to.current.all.add(vector);
  const double place = block.rotation_hz / settings_.class_hz;
  if (place < kMostClasses) to.current.by_speed[static_cast<int>(place)].add(vector);
}

bool OrderVectors::has_phase(std::size_t order) const {
  return settings_.known_share > 0.0 && is_whole(settings_.order[order] * settings_.known_share);
}

OrderVectors::Result OrderVectors::result(int channel, std::size_t order) const {
  const Accumulator& from = accumulator_[static_cast<std::size_t>(channel) * settings_.order.size() + order];
  const Sums& sums = from.best.all.count() > from.current.all.count() ? from.best : from.current;
  Result result{sums.all, {}};
  for (const auto& [number, vector] : sums.by_speed)
    result.by_speed.push_back({number * settings_.class_hz, (number + 1) * settings_.class_hz, vector});
  return result;
}

}  // namespace roadbalance
