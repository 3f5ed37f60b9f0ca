#include "host/analysis/orders/mean_vector.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <random>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using Random = std::mt19937_64;
/// Noise of vector number k of a drive; may keep what it needs from one to the next.
using Noise = std::function<Complex(Random&, int k)>;

const Complex kTruth = std::polar(1.0, 2.1);

bool holds(const MeanVector& vector, Complex truth) {
  const Complex off = truth - vector.mean();
  const Eigen::Vector2d d(off.real(), off.imag());
  const auto confidence = vector.confidence();
  return d.dot(confidence->covariance.inverse() * d) <= confidence->limit;
}

struct Coverage {
  double ellipse = 0.0, amplitude = 0.0, phase = 0.0;  ///< share of drives whose statement holds
  double reach = 0.0;                                  ///< mean of the stated uncertainty of the amplitude
};

/// @param noise  makes the noise of one drive
Coverage coverage(int drives, int vectors, const std::function<Noise(Random&)>& noise) {
  Random random(2024);
  Coverage share;
  for (int drive = 0; drive < drives; ++drive) {
    MeanVector vector;
    const Noise of_this_drive = noise(random);
    for (int k = 0; k < vectors; ++k) vector.add(kTruth + of_this_drive(random, k));
    const auto confidence = vector.confidence();
    const double turned = std::arg(vector.mean() / kTruth);
    share.ellipse += holds(vector, kTruth);
    share.amplitude += std::abs(std::abs(vector.mean()) - 1.0) <= confidence->amplitude;
    share.phase += !confidence->phase_rad || std::abs(turned) <= *confidence->phase_rad;
    share.reach += confidence->amplitude;
  }
  share.ellipse /= drives;
  share.amplitude /= drives;
  share.phase /= drives;
  share.reach /= drives;
  return share;
}

Noise white(double sigma, double across = 1.0) {
  return [=](Random& random, int) {
    std::normal_distribution<double> normal(0.0, sigma);
    const double x = normal(random), y = across * normal(random);
    return Complex(x, y);
  };
}

constexpr int kDrives = 4000;
constexpr double kThreeSigma = 3.0 * 0.0035;  // sqrt(0.95 * 0.05 / 4000)

TEST(MeanVector, HoldsTheTruthInNineteenOfTwentyDrives) {
  for (const int vectors : {6, 10, 20, 100, 400}) {
    const Coverage share = coverage(kDrives, vectors, [](Random&) { return white(0.5); });
    // Choosing the largest of several variances errs on the safe side.
    EXPECT_GT(share.ellipse, 0.95 - kThreeSigma) << vectors;
    EXPECT_LT(share.ellipse, 0.99) << vectors;
    EXPECT_GT(share.amplitude, 0.95 - kThreeSigma) << vectors;
    EXPECT_GT(share.phase, 0.95 - kThreeSigma) << vectors;
    std::printf("white %4d: ellipse %.3f amplitude %.3f phase %.3f reach %.4f\n", vectors, share.ellipse,
                share.amplitude, share.phase, share.reach);
    if (vectors == 400) {  // sigma / sqrt(n) times the root of the limit, 2.45 of 2.45 .. 2.9 of 12 batches
      EXPECT_GT(share.reach, 2.45 * 0.5 / 20.0);
      EXPECT_LT(share.reach, 1.5 * 2.45 * 0.5 / 20.0);
    }
  }
}

TEST(MeanVector, HoldsTheTruthWhereTheScatterIsNotRound) {
  const Coverage share = coverage(kDrives, 60, [](Random&) { return white(0.5, 0.05); });
  std::printf("flat: ellipse %.3f\n", share.ellipse);
  EXPECT_GT(share.ellipse, 0.95 - kThreeSigma);
  EXPECT_LT(share.ellipse, 0.99);
}

TEST(MeanVector, HoldsTheTruthWhereBlocksDependOnEachOther) {
  // First-order dependence rho = 0.7: the mean scatters sqrt((1 + rho) / (1 - rho)) = 2.4 times as much as
  // single vectors say; taken as independent, 41 % of the drives would be right.
  const auto dependent = [](Random&) -> Noise {
    return [state = Complex(0.0)](Random& random, int) mutable {
      state = 0.7 * state + white(0.3)(random, 0);
      return state;
    };
  };
  const Coverage share = coverage(kDrives, 400, dependent);
  std::printf("dependent: ellipse %.3f\n", share.ellipse);
  EXPECT_GT(share.ellipse, 0.93);  // batches of 32 still depend a little
  EXPECT_LT(share.ellipse, 0.99);
}

TEST(MeanVector, HoldsTheTruthWhereAnotherWheelBeats) {
  // Half the amplitude, a beat of 45 blocks, any phase: nine beats a drive.
  const auto beat = [](Random& random) -> Noise {
    const double phase = std::uniform_real_distribution<double>(0.0, 2.0 * std::numbers::pi)(random);
    return [=](Random& r, int k) {
      return std::polar(0.5, phase + 2.0 * std::numbers::pi * k / 45.3) + white(0.1)(r, k);
    };
  };
  const Coverage share = coverage(kDrives, 400, beat);
  std::printf("beat: ellipse %.3f\n", share.ellipse);
  EXPECT_GT(share.ellipse, 0.95 - kThreeSigma);
}

TEST(MeanVector, SaysThatThereMayBeNoVectorAtAll) {
  Random random(7);
  int claimed = 0;
  constexpr int kTries = 2000;
  for (int i = 0; i < kTries; ++i) {
    MeanVector vector;
    for (int k = 0; k < 50; ++k) vector.add(white(1.0)(random, k));
    claimed += vector.confidence()->phase_rad.has_value();
  }
  EXPECT_LT(claimed, kTries * (0.05 + 0.015));  // 3 sigma of 2000 tries
  EXPECT_GT(claimed, 0);
}

TEST(MeanVector, ClaimsNothingOfAFewVectors) {
  MeanVector vector;
  for (int k = 0; k < MeanVector::kLeastVectors; ++k) {
    EXPECT_FALSE(vector.confidence());
    vector.add(kTruth);
  }
  EXPECT_EQ(vector.count(), MeanVector::kLeastVectors);
  EXPECT_NEAR(std::abs(vector.mean() - kTruth), 0.0, 1e-15);
  ASSERT_TRUE(vector.confidence());
  EXPECT_NEAR(*vector.confidence()->phase_rad, 0.0, 1e-12) << "no scatter, no doubt";
}

}  // namespace
}  // namespace roadbalance
