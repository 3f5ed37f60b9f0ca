#include "host/analysis/orders/crossing_orders.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "common/dsp/decimation.hpp"
#include "common/types/angle_units.hpp"
#include "host/analysis/orders/order_vectors.hpp"

namespace roadbalance {
namespace {

const std::vector<double>& checked(const std::vector<double>& order, const std::vector<Rotor>& rotor) {
  if (rotor.empty() || order.empty())
    throw std::invalid_argument("Vold-Kalman: there must be a rotor and an order");
  if (rotor.size() * order.size() > CrossingOrders::kMostOrders)
    throw std::invalid_argument("Vold-Kalman: " + std::to_string(order.size()) + " orders of " +
                                std::to_string(rotor.size()) + " rotors are more than " +
                                std::to_string(CrossingOrders::kMostOrders) + " together");
  for (const double h : order)
    for (const Rotor& of : rotor)
      if (!(h > 0.0) || of.known_share == 0.0 || !is_whole(h * of.known_share))
        throw std::invalid_argument("Vold-Kalman: order " + std::to_string(h) + " of " + of.name +
                                    " has no phase that lasts");
  return order;
}

/// So that the low-pass passes the highest order of the fastest wheel.
int factor_of(const NodeConfig& node, const std::vector<Rotor>& rotor, const std::vector<double>& order) {
  double highest_hz = 0.0;
  for (const Rotor& of : rotor)
    highest_hz = std::max(highest_hz, std::ranges::max(order) * of.ratio * CrossingOrders::kFastest_hz);
  if (highest_hz > 0.4 * node.rate_hz)
    throw std::invalid_argument("Vold-Kalman: order " + std::to_string(std::ranges::max(order)) +
                                " is too high for " + std::to_string(node.rate_hz) + " samples a second");
  return std::max(1, static_cast<int>(kDecimationFlatTo * node.rate_hz / highest_hz));
}

}  // namespace

CrossingOrders::CrossingOrders(const VehicleConfig& vehicle, std::vector<Rotor> rotor, int node,
                               std::vector<std::size_t> channel, std::vector<double> order,
                               double bandwidth_hz)
    : rotor_(std::move(rotor)),
      node_(vehicle.node[static_cast<std::size_t>(node)]),
      channel_(std::move(channel)),
      si_(node_, channel_),
      order_(checked(order, rotor_)),
      recorded_(vehicle.filter),
      factor_(factor_of(node_, rotor_, order_)),
      filter_{node_.rate_hz / factor_, bandwidth_hz},
      taps_(decimation_taps(factor_)),
      values_(std::ssize(channel_), taps_.size()),
      angles_(std::ssize(rotor_), taps_.size()),
      result_(channel_.size() * rotor_.size() * order_.size()),
      blocks_(filter_, static_cast<int>(channel_.size()), static_cast<int>(rotor_.size() * order_.size()),
              [this](const VoldKalmanBlocks::Block& block) { judge(block); }),
      join_(nodes_of(vehicle, rotor_, node), [this](const GridJoin::Row& row) { take(row); }) {
  const auto nodes = nodes_of(vehicle, rotor_, node);
  for (const Rotor& of : rotor_) {
    angle_.emplace_back(vehicle, of, nodes);
    class_hz_.push_back(of.class_hz(vehicle));
  }
}

double CrossingOrders::order_of(Eigen::Index column) const {
  return order_[static_cast<std::size_t>(column) % order_.size()];
}

std::size_t CrossingOrders::rotor_of(Eigen::Index column) const {
  return static_cast<std::size_t>(column) / order_.size();
}

void CrossingOrders::take(const GridJoin::Row& row) {
  if (row.restart) end_run();
  const auto last = taps_.size() - 1;
  // Moved all together: taps are few, and the filter behind costs more.
  if (filled_ > last) {
    values_.leftCols(last) = values_.rightCols(last).eval();
    angles_.leftCols(last) = angles_.rightCols(last).eval();
    row_overload_.pop_front();
    --filled_;
  }
  bool all_known = true;
  for (std::size_t r = 0; r < rotor_.size(); ++r) {
    const RotorAngle::Reading reading = angle_[r].read(row);
    all_known = all_known && reading.state == RotorAngle::State::kKnown;
    angles_(static_cast<Eigen::Index>(r), filled_) = reading.angle_rad;
  }
  if (!all_known) return end_run();
  row_overload_.push_back(si_.read(row.sample.front(), values_.col(filled_)));
  ++filled_;
  if (filled_ > last && rows_++ % factor_ == 0) {
    std::uint32_t any = 0;
    for (const std::uint32_t one : row_overload_) any |= one;
    take_sample(any);
  }
}

/// The rows behind the low-pass, and where the rotors stood amid them.
void CrossingOrders::take_sample(std::uint32_t overload) {
  const Eigen::Index amid = taps_.size() / 2, from = std::max<Eigen::Index>(0, amid - 1);
  const Eigen::Index to = std::min(taps_.size() - 1, amid + 1);
  Eigen::VectorXd phase(std::ssize(rotor_) * std::ssize(order_));
  for (std::size_t r = 0; r < rotor_.size(); ++r) {
    const auto of = static_cast<Eigen::Index>(r);
    const double turning_hz = (angles_(of, to) - angles_(of, from)) * node_.rate_hz /
                              (kTurn * static_cast<double>(std::max<Eigen::Index>(1, to - from)));
    const double wheel_hz = turning_hz / rotor_[r].ratio;
    if (taps_.size() > 1 && !(wheel_hz >= kLeast_hz && wheel_hz <= kFastest_hz)) return end_run();
    for (std::size_t i = 0; i < order_.size(); ++i)
      phase(static_cast<Eigen::Index>(r * order_.size() + i)) = order_[i] * angles_(of, amid);
  }
  overload_.push_back(overload);
  blocks_.add(values_ * taps_, phase);
}

void CrossingOrders::end_run() {
  blocks_.end_run();
  for (RotorAngle& angle : angle_) angle.forget();
  row_overload_.clear();
  overload_.clear();
  overload_from_ = filled_ = rows_ = 0;
}

void CrossingOrders::judge(const VoldKalmanBlocks::Block& block) {
  // One vector for each 1/B: nearer ones hold nothing new.
  const auto hop = static_cast<Eigen::Index>(std::lround(filter_.rate_hz / filter_.bandwidth_hz));
  for (Eigen::Index row = block.first; row < block.first + block.count; ++row)
    if ((block.at + row) % hop == 0 && row >= hop && row + hop < block.phase_rad.rows()) judge(block, row);
  while (overload_from_ < block.at + block.first + block.count - hop && !overload_.empty()) {
    overload_.pop_front();
    ++overload_from_;
  }
}

void CrossingOrders::judge(const VoldKalmanBlocks::Block& block, Eigen::Index row) {
  const auto hop = static_cast<Eigen::Index>(std::lround(filter_.rate_hz / filter_.bandwidth_hz));
  const double seconds = static_cast<double>(hop) / filter_.rate_hz;
  std::uint32_t overload = 0;
  for (Eigen::Index at = block.at + row - hop; at <= block.at + row + hop; ++at)
    if (const Eigen::Index k = at - overload_from_; k >= 0 && k < std::ssize(overload_))
      overload |= overload_[static_cast<std::size_t>(k)];
  for (Eigen::Index order = 0; order < block.phase_rad.cols(); ++order) {
    const Rotor& rotor = rotor_[rotor_of(order)];
    const double h = order_of(order);
    const double rotation_hz =
        (block.phase_rad(row + hop, order) - block.phase_rad(row - hop, order)) / (kTurn * h * 2.0 * seconds);
    const bool together = stays_with_another(block.phase_rad, row, order);
    const auto recorded = recorded_.on_order(h * rotor.ratio, rotation_hz / rotor.ratio);
    const auto speed = static_cast<int>(rotation_hz / class_hz_[rotor_of(order)]);
    for (std::size_t c = 0; c < channel_.size(); ++c) {
      if ((overload >> c & 1U) != 0) continue;
      Result& result =
          result_[c * static_cast<std::size_t>(block.phase_rad.cols()) + static_cast<std::size_t>(order)];
      (together ? result.together_s : result.used_s) += seconds;
      if (together) continue;
      const auto vector = block.envelope[c](row, order) / recorded;
      result.all.add(vector);
      if (speed < OrderVectors::kMostClasses) result.by_speed[speed].add(vector);
    }
  }
}

bool CrossingOrders::stays_with_another(const Eigen::MatrixXd& phase_rad, Eigen::Index row,
                                        Eigen::Index order) const {
  const auto hop = static_cast<Eigen::Index>(std::lround(filter_.rate_hz / filter_.bandwidth_hz));
  for (Eigen::Index other = 0; other < phase_rad.cols(); ++other) {
    if (other == order) continue;
    const auto apart =
        (phase_rad.col(order) - phase_rad.col(other)).segment(row - hop, 2 * hop + 1).array().eval();
    if (apart.maxCoeff() - apart.minCoeff() < 0.5 * kTurn) return true;
  }
  return false;
}

const CrossingOrders::Result* CrossingOrders::find(const std::string& rotor, std::size_t channel,
                                                   double order) const {
  const auto r = std::ranges::find(rotor_, rotor, &Rotor::name);
  const auto c = std::ranges::find(channel_, channel);
  const auto h = std::ranges::find(order_, order);
  if (r == rotor_.end() || c == channel_.end() || h == order_.end()) return nullptr;
  const auto column = static_cast<std::size_t>(r - rotor_.begin()) * order_.size() +
                      static_cast<std::size_t>(h - order_.begin());
  return &result_[static_cast<std::size_t>(c - channel_.begin()) * rotor_.size() * order_.size() + column];
}

double CrossingOrders::class_hz(const std::string& rotor) const {
  const auto r = std::ranges::find(rotor_, rotor, &Rotor::name);
  return class_hz_[static_cast<std::size_t>(r - rotor_.begin())];
}

}  // namespace roadbalance
