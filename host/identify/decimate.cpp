#include "host/identify/decimate.hpp"

#include <cmath>
#include <numbers>
#include <utility>

namespace roadbalance {
namespace {

/// Kaiser window times sinc, gain 1 at rest.
Eigen::VectorXd low_pass(int factor) {
  if (factor == 1) return Eigen::VectorXd::Ones(1);
  const int half = 8 * factor;
  const double cutoff = 0.4 / factor;  // in units of the grid rate
  constexpr double kBeta = 8.0;
  Eigen::VectorXd taps(2 * half + 1);
  for (int k = -half; k <= half; ++k) {
    const double x = 2.0 * std::numbers::pi * cutoff * k;
    const double position = static_cast<double>(k) / half;
    const double window = std::cyl_bessel_i(0.0, kBeta * std::sqrt(1.0 - position * position));
    taps(k + half) = window * (k == 0 ? 1.0 : std::sin(x) / x);
  }
  return taps / taps.sum();
}

}  // namespace

Decimator::Decimator(int factor, Emit emit)
    : factor_(factor),
      taps_(low_pass(factor)),
      history_(SignalMatrix::Zero(kSignals, 8 * taps_.size())),
      emit_(std::move(emit)) {}

void Decimator::consume(const SignalRun& run) {
  if (run.restart) {
    filled_ = 0;
    restart_ = true;
  }
  const Eigen::Index n = taps_.size();
  for (Eigen::Index i = 0; i < run.samples.cols(); ++i) {
    if (filled_ == history_.cols()) {
      history_.leftCols(n - 1) = history_.rightCols(n - 1).eval();
      filled_ = n - 1;
    }
    history_.col(filled_++) = run.samples.col(i);
    const std::int64_t centre = run.first_index + i - (n - 1) / 2;
    if (filled_ < n || centre % factor_ != 0) continue;
    IdentificationSample sample;
    sample.signals.noalias() = history_.middleCols(filled_ - n, n) * taps_;
    sample.restart = std::exchange(restart_, false);
    sample.time_ns = run.time_ns;
    emit_(sample);
  }
}

}  // namespace roadbalance
