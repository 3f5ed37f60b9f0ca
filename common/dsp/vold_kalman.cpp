#include "common/dsp/vold_kalman.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace roadbalance {
namespace {

constexpr double kPi = std::numbers::pi;
using Sparse = Eigen::SparseMatrix<double>;

/// Rows of the second differences of n samples: D'D is banded with these on its diagonals.
double smoothness(Eigen::Index n, Eigen::Index i, Eigen::Index distance) {
  // Sum over the differences d = 1 .. n - 2, each (1, -2, 1) about d, of their parts at i and i + distance.
  constexpr double kPart[3] = {1.0, -2.0, 1.0};
  double sum = 0.0;
  for (Eigen::Index d = std::max<Eigen::Index>(1, i - 1); d <= std::min(n - 2, i + 1); ++d) {
    const Eigen::Index here = i - d + 1, there = i + distance - d + 1;
    if (there <= 2) sum += kPart[here] * kPart[there];
  }
  return sum;
}

/// cos theta, -sin theta of each order: what Re X and Im X do to the sample.
Eigen::VectorXd reference(const Eigen::MatrixXd& phase_rad, Eigen::Index n) {
  Eigen::VectorXd row(2 * phase_rad.cols());
  for (Eigen::Index k = 0; k < phase_rad.cols(); ++k) {
    row(2 * k) = std::cos(phase_rad(n, k));
    row(2 * k + 1) = -std::sin(phase_rad(n, k));
  }
  return row;
}

/// Lower half of the normal matrix, unknowns of a sample side by side.
Sparse normal_matrix(const Eigen::MatrixXd& phase_rad, double weight) {
  const Eigen::Index n = phase_rad.rows(), u = 2 * phase_rad.cols();
  Sparse matrix(n * u, n * u);
  matrix.reserve(Eigen::VectorXi::Constant(static_cast<int>(n * u), static_cast<int>(u + 2)));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::VectorXd row = reference(phase_rad, i);
    for (Eigen::Index a = 0; a < u; ++a) {
      for (Eigen::Index b = a; b < u; ++b)
        matrix.insert(i * u + b, i * u + a) = row(a) * row(b) + (a == b ? weight * smoothness(n, i, 0) : 0.0);
      for (Eigen::Index next = 1; next <= 2 && i + next < n; ++next)
        matrix.insert((i + next) * u + a, i * u + a) = weight * smoothness(n, i, next);
    }
  }
  matrix.makeCompressed();
  return matrix;
}

}  // namespace

double VoldKalman::weight() const {
  if (!(bandwidth_hz >= kLeastShare * rate_hz && bandwidth_hz <= 0.5 * rate_hz))
    throw std::invalid_argument("Vold-Kalman bandwidth of " + std::to_string(bandwidth_hz) +
                                " Hz: must lie between a thousandth and half of the rate, " +
                                std::to_string(rate_hz) + " Hz");
  return (std::numbers::sqrt2 - 1.0) / std::pow(2.0 * std::sin(0.5 * kPi * bandwidth_hz / rate_hz), 4);
}

double VoldKalman::passes(double off_hz) const {
  return 1.0 / (1.0 + weight() * std::pow(2.0 * std::sin(kPi * off_hz / rate_hz), 4));
}

Eigen::Index VoldKalman::reach() const {
  return static_cast<Eigen::Index>(std::ceil(6.0 * rate_hz / bandwidth_hz));
}

std::vector<Eigen::MatrixXcd> VoldKalman::track(const Eigen::MatrixXd& samples,
                                                const Eigen::MatrixXd& phase_rad) const {
  const Eigen::Index n = samples.rows(), orders = phase_rad.cols(), u = 2 * orders;
  if (phase_rad.rows() != n || n < 3 || orders < 1)
    throw std::invalid_argument("Vold-Kalman: samples and phases must have the same three rows or more");
  const Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> factor(
      normal_matrix(phase_rad, 0.5 * weight()));
  Eigen::MatrixXd right(n * u, samples.cols());
  for (Eigen::Index i = 0; i < n; ++i) right.middleRows(i * u, u) = reference(phase_rad, i) * samples.row(i);
  const Eigen::MatrixXd found = factor.solve(right);
  std::vector<Eigen::MatrixXcd> envelope;
  for (Eigen::Index c = 0; c < samples.cols(); ++c) {
    Eigen::MatrixXcd& of = envelope.emplace_back(n, orders);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index k = 0; k < orders; ++k)
        of(i, k) = {found(i * u + 2 * k, c), found(i * u + 2 * k + 1, c)};
  }
  return envelope;
}

VoldKalmanBlocks::VoldKalmanBlocks(const VoldKalman& filter, int channels, int orders, Emit emit)
    : filter_(filter), reach_(filter.reach()), emit_(std::move(emit)) {
  (void)filter.weight();
  // Half of a block is surroundings: twice the work of an endless one, and no more memory than it needs.
  values_.resize(channels, 4 * reach_);
  phase_rad_.resize(orders, 4 * reach_);
}

void VoldKalmanBlocks::add(const Eigen::Ref<const Eigen::VectorXd>& values,
                           const Eigen::Ref<const Eigen::VectorXd>& phase_rad) {
  values_.col(filled_) = values;
  phase_rad_.col(filled_++) = phase_rad;
  if (filled_ < values_.cols()) return;
  track(filled_ - reach_);
  // The next run needs as much before it.
  const Eigen::Index keep = 2 * reach_, drop = filled_ - keep;
  values_.leftCols(keep) = values_.middleCols(drop, keep).eval();
  phase_rad_.leftCols(keep) = phase_rad_.middleCols(drop, keep).eval();
  filled_ = keep;
  reported_ -= drop;
  at_ += drop;
}

void VoldKalmanBlocks::end_run() {
  if (filled_ >= 2 * reach_ && reported_ < filled_) track(filled_);
  filled_ = reported_ = at_ = 0;
}

void VoldKalmanBlocks::track(Eigen::Index upto) {
  const Eigen::MatrixXd phase_rad = phase_rad_.leftCols(filled_).transpose();
  const auto envelope = filter_.track(values_.leftCols(filled_).transpose(), phase_rad);
  emit_({phase_rad, envelope, reported_, upto - reported_, at_});
  reported_ = upto;
}

}  // namespace roadbalance
