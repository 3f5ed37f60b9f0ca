#include "common/dsp/vold_kalman.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kRate_hz = 250.0;

/// theta of a frequency that grows linearly.
Eigen::VectorXd chirp(Eigen::Index n, double from_hz, double to_hz) {
  Eigen::VectorXd phase(n);
  const double length_s = static_cast<double>(n) / kRate_hz;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / kRate_hz;
    phase(i) = kTurn * (from_hz * t + 0.5 * (to_hz - from_hz) * t * t / length_s);
  }
  return phase;
}

Eigen::VectorXd wave(const Eigen::VectorXd& phase, Complex amplitude) {
  return phase.unaryExpr([&](double p) { return (amplitude * std::polar(1.0, p)).real(); });
}

Eigen::VectorXd white(Eigen::Index n, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, sigma);
  return Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
}

TEST(VoldKalman, PassesWhatLiesOffTheOrderByTheFormulaOfItsBandwidth) {
  const VoldKalman filter{kRate_hz, 1.0};
  EXPECT_NEAR(filter.passes(0.5), 1.0 / std::numbers::sqrt2, 1e-12) << "half the power at half the width";
  constexpr Eigen::Index kSamples = 12'000;
  const Eigen::VectorXd order = chirp(kSamples, 20.0, 20.0);
  for (const double off_hz : {0.0, 0.25, 0.5, -0.5, 1.0, 3.0}) {
    const auto envelope =
        filter.track(wave(chirp(kSamples, 20.0 + off_hz, 20.0 + off_hz), 1.0), order).front();
    // Far from the ends; what the order's own negative frequency does is 1e-6: 40 Hz off.
    const double middle = std::abs(envelope(kSamples / 2, 0));
    const double off = 2.0 * std::sin(std::numbers::pi * off_hz / kRate_hz);
    const double half = 2.0 * std::sin(std::numbers::pi * 0.5 / kRate_hz);
    EXPECT_NEAR(middle, 1.0 / (1.0 + (std::numbers::sqrt2 - 1.0) * std::pow(off / half, 4)), 1e-5) << off_hz;
  }
}

/// Two orders that cross at 18 Hz, and noise.
struct Crossing {
  static constexpr Eigen::Index kSamples = 15'000;  ///< 60 s
  const Complex first = std::polar(1.0, 0.7), second = std::polar(0.6, -2.0);
  Eigen::MatrixXd phase{kSamples, 2};
  Eigen::VectorXd samples;

  explicit Crossing(double noise) {
    phase.col(0) = chirp(kSamples, 12.0, 24.0);
    phase.col(1) = chirp(kSamples, 24.0, 12.0);
    samples = wave(phase.col(0), first) + wave(phase.col(1), second) + white(kSamples, noise, 4);
  }
};

TEST(VoldKalman, TellsCrossingOrdersApartWhereABlockOfTurnsCannot) {
  const Crossing crossing(0.0);
  const VoldKalman filter{kRate_hz, 1.0};
  const Eigen::MatrixXcd envelope = filter.track(crossing.samples, crossing.phase).front();
  const Eigen::Index middle = Crossing::kSamples / 2, around = filter.reach();
  double worst = 0.0;
  for (Eigen::Index i = middle - around; i <= middle + around; ++i)
    worst = std::max(
        {worst, std::abs(envelope(i, 0) - crossing.first), std::abs(envelope(i, 1) - crossing.second)});
  EXPECT_LT(worst, 0.01);

  // Eight turns about the crossing hold the other order as good as whole.
  const Eigen::Index block = static_cast<Eigen::Index>(8.0 / 18.0 * kRate_hz);
  Complex fourier = 0.0;
  for (Eigen::Index i = middle - block / 2; i < middle + block / 2; ++i)
    fourier +=
        2.0 / static_cast<double>(block) * crossing.samples(i) * std::polar(1.0, -crossing.phase(i, 0));
  EXPECT_GT(std::abs(fourier - crossing.first), 0.4);
  // Nor does a Vold-Kalman filter of one order alone.
  const Eigen::MatrixXcd alone = filter.track(crossing.samples, crossing.phase.leftCols(1)).front();
  EXPECT_GT(std::abs(alone(middle, 0) - crossing.first), 0.3);
}

TEST(VoldKalman, ScattersByTheNoiseThatItsBandwidthPasses) {
  constexpr double kNoise = 0.5;
  const Crossing crossing(kNoise);
  const VoldKalman filter{kRate_hz, 1.0};
  const Eigen::MatrixXcd envelope = filter.track(crossing.samples, crossing.phase).front();
  // E|X - X0|^2 = 4 sigma^2 / rate times the integral of H^2 over all frequencies.
  double passed_hz = 0.0;
  constexpr double kStep_hz = 0.001;
  for (double f = -20.0; f < 20.0; f += kStep_hz) passed_hz += kStep_hz * std::pow(filter.passes(f), 2);
  const double expected = 4.0 * kNoise * kNoise / kRate_hz * passed_hz;
  double square = 0.0;
  const Eigen::Index from = filter.reach(), to = Crossing::kSamples - filter.reach();
  for (Eigen::Index i = from; i < to; ++i) square += std::norm(envelope(i, 0) - crossing.first);
  square /= static_cast<double>(to - from);
  // About one independent value each second of the 48, of two degrees of freedom: 14 %; four sigma.
  EXPECT_NEAR(square, expected, 0.58 * expected);
}

/// The largest difference between tracking in blocks and as a whole.
double cost_of_blocks(const Crossing& crossing) {
  const VoldKalman filter{kRate_hz, 1.5};
  const Eigen::MatrixXcd whole = filter.track(crossing.samples, crossing.phase).front();
  Eigen::MatrixXcd joined(Crossing::kSamples, 2);
  Eigen::Index told = 0;
  VoldKalmanBlocks blocks(filter, 1, 2, [&](const VoldKalmanBlocks::Block& block) {
    EXPECT_LE(block.phase_rad.rows(), 4 * filter.reach()) << "memory is bounded";
    joined.middleRows(told, block.count) = block.envelope.front().middleRows(block.first, block.count);
    told += block.count;
  });
  for (Eigen::Index i = 0; i < Crossing::kSamples; ++i)
    blocks.add(Eigen::VectorXd::Constant(1, crossing.samples(i)), crossing.phase.row(i).transpose());
  blocks.end_run();
  EXPECT_EQ(told, Crossing::kSamples);

  // A run too short for any envelope that does not hang on its ends gives nothing, nor does it reach the
  // next.
  for (Eigen::Index i = 0; i < filter.reach(); ++i)
    blocks.add(Eigen::VectorXd::Constant(1, 1e6), crossing.phase.row(i).transpose());
  blocks.end_run();
  EXPECT_EQ(told, Crossing::kSamples);
  return (joined - whole).cwiseAbs().maxCoeff();
}

TEST(VoldKalman, InBlocksIsWhatItIsOverTheWhole) {
  Crossing apart(0.5);
  apart.phase.col(1) = chirp(Crossing::kSamples, 24.0, 36.0);
  EXPECT_LT(cost_of_blocks(apart), 1e-5);
  // Instants that separate crossing orders lie further away; noise scatters them by 0.1 here.
  EXPECT_LT(cost_of_blocks(Crossing(0.5)), 0.01);
}

TEST(VoldKalman, RefusesABandwidthThatLeavesNoDigits) {
  EXPECT_THROW((void)(VoldKalman{kRate_hz, 0.1}.weight()), std::invalid_argument);
  EXPECT_THROW((void)(VoldKalman{kRate_hz, 130.0}.weight()), std::invalid_argument);
  EXPECT_THROW((void)(VoldKalman{kRate_hz, 1.0}.track(Eigen::MatrixXd(5, 1), Eigen::MatrixXd(4, 1))),
               std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
