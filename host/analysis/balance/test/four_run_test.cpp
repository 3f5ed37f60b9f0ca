#include "host/analysis/balance/four_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <stdexcept>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr double kDegree = std::numbers::pi / 180.0;

/// A rotor that answers to weights of its plane linearly.
struct LinearRotor {
  Complex bare = std::polar(3.0, 0.7), influence = std::polar(0.2, -2.0);
  double amplitude(Complex weight) const { return std::abs(bare + influence * weight); }
  Complex correction() const { return -bare / influence; }
  std::vector<AmplitudeRun> trials(double mass, std::initializer_list<double> degrees,
                                   double sigma = 0.0) const {
    std::vector<AmplitudeRun> runs;
    for (const double d : degrees)
      runs.push_back({d * kDegree, amplitude(std::polar(mass, d * kDegree)), sigma});
    return runs;
  }
};

TEST(FourRuns, FindTheWeightWithoutAnyPhase) {
  const LinearRotor rotor;
  for (const auto& angles : {std::initializer_list<double>{0, 120, 240}, {10, 100, 200, 300}}) {
    const auto found =
        balance_by_four_runs({0.0, rotor.amplitude(0.0), 0.0}, rotor.trials(10.0, angles), 10.0);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->mass, 15.0, 1e-9);
    EXPECT_NEAR(std::remainder(found->angle_rad - std::arg(rotor.correction()), 2 * std::numbers::pi), 0.0,
                1e-9);
    EXPECT_NEAR(found->agreement, 1.0, 1e-9);
    EXPECT_NEAR(rotor.amplitude(std::polar(found->mass, found->angle_rad)), 0.0, 1e-8);
  }
}

TEST(FourRuns, KnowTheirUncertainty) {
  const LinearRotor rotor;
  const double sigma = 0.02;
  const auto stated = balance_by_four_runs({0.0, rotor.amplitude(0.0), sigma},
                                           rotor.trials(10.0, {0, 120, 240}, sigma), 10.0);
  ASSERT_TRUE(stated);
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0.0, sigma);
  double mass = 0.0, angle = 0.0;
  constexpr int kDraws = 4000;
  for (int k = 0; k < kDraws; ++k) {
    auto runs = rotor.trials(10.0, {0, 120, 240}, sigma);
    for (auto& run : runs) run.amplitude += normal(random);
    const auto found = balance_by_four_runs({0.0, rotor.amplitude(0.0) + normal(random), sigma}, runs, 10.0);
    ASSERT_TRUE(found);
    mass += std::pow(found->mass - stated->mass, 2) / kDraws;
    angle += std::pow(found->angle_rad - stated->angle_rad, 2) / kDraws;
  }
  EXPECT_NEAR(stated->mass_sigma / std::sqrt(mass), 1.0, 0.06);
  EXPECT_NEAR(stated->angle_sigma_rad / std::sqrt(angle), 1.0, 0.06);
}

TEST(FourRuns, RefuseWhatContradictsOrTellsNothing) {
  const LinearRotor rotor;
  const AmplitudeRun bare{0.0, rotor.amplitude(0.0), 0.01};
  EXPECT_FALSE(balance_by_four_runs(bare, rotor.trials(10.0, {0, 120}), 10.0));
  EXPECT_FALSE(balance_by_four_runs(bare, rotor.trials(10.0, {0, 120, 120}), 10.0)) << "two angles";
  EXPECT_FALSE(balance_by_four_runs(bare, rotor.trials(0.05, {0, 120, 240}, 0.01), 0.05))
      << "lost in the noise";
  auto halved = rotor.trials(10.0, {0, 120, 240}, 0.01);
  for (auto& run : halved) run.amplitude += 2.0;
  EXPECT_FALSE(balance_by_four_runs(bare, halved, 10.0)) << "no linear rotor shows these";
  EXPECT_THROW(balance_by_four_runs(bare, {}, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
