#include <gtest/gtest.h>

#include <cstdio>
#include <random>

#include "host/analysis/identify/car_posterior.hpp"
#include "host/analysis/identify/estimate_covariance.hpp"
#include "sim/drawn_car.hpp"
#include "tools/study/ideal_drive.hpp"
#include "tools/study/test/gathered_drive.hpp"

namespace roadbalance {
namespace {

constexpr std::uint64_t kSeed = 5;
constexpr double kNoise_m_s2 = 0.02;

/// The demonstration car behind a vertical sensor on each carrier and at each strut top.
CarPrior demo_prior(const VehicleConfig& vehicle) {
  const Priors known = Priors::of(vehicle);
  CarPrior prior{.geometry = known.geometry,
                 .value = known.value,
                 .sigma = {},
                 .sensors = {},
                 .gain_sigma = {},
                 .noise_m2_s4_hz = 0.0};
  prior.sigma << 0.03, 0.1, 0.1, 0.02, 0.02, 0.02, 0.02, 0.3, 0.3, 0.3, 0.3, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5,
      0.3, 0.3, 0.3, 0.3, 50.0, 50.0, 50.0, 50.0;
  prior.sensors = Eigen::MatrixXd::Zero(2 * kWheels, kCoordinates);
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    prior.sensors(i, kBodyCoordinates + i) = 1.0;
    prior.sensors.row(kWheels + i).head<3>() << 1.0, known.geometry.y_m[w], -known.geometry.x_m[w];
  }
  prior.gain_sigma = Eigen::VectorXd::Constant(2 * kWheels, 0.01);
  prior.noise_m2_s4_hz = 0.25 * kNoise_m_s2 * kNoise_m_s2 / 500.0;
  return prior;
}

struct Case {
  const char* name;
  sim::RoadScenario road;
};

class PosteriorOfADrive : public testing::TestWithParam<Case> {};

// 60 s at each of four speeds on a road of class A, of whose shape nothing is said.  Where the sides'
// exponents differ their coherence changes with the wave number, which the posterior takes for constant:
// springs and masses, which scale alike, are then nearly four standard deviations off; the tyres hold.
TEST_P(PosteriorOfADrive, HoldsTheTyresWhateverTheRoad) {
  const VehicleConfig& vehicle = test::demo_car();
  IdealDrive drive = test::plateaus({90.0, 103.0, 117.0, 130.0}, 64);
  drive.scenario.road = GetParam().road;
  const CarPrior prior = demo_prior(vehicle);
  const Eigen::Index channels = prior.sensors.rows();
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> noise(0.0, kNoise_m_s2);
  SpectralGatherer gatherer(prior.geometry.x_m[0] - prior.geometry.x_m[2], drive.rate_hz);
  std::vector<SpectralMoments> speeds;
  for (const Stretch& stretch : drive_ideally(drive, kSeed, vehicle)) {
    MotionIntegrals integrals(channels, stretch.rate_hz);
    Eigen::MatrixXd motion(3 * channels, stretch.signals.cols());
    for (Eigen::Index k = 0; k < motion.cols(); ++k) {
      Eigen::ArrayXd reading = (prior.sensors * stretch.signals.col(k).head<kCoordinates>()).array();
      for (double& value : reading) value += noise(random);
      integrals.update(reading, motion.col(k).array());
    }
    const auto settled = static_cast<Eigen::Index>(MotionIntegrals::kSettling_s * stretch.rate_hz);
    speeds.push_back(
        gatherer.moments(motion.rightCols(motion.cols() - settled), stretch.omega, stretch.speed_m_s));
  }
  std::vector<const SpectralMoments*> all;
  for (const SpectralMoments& speed : speeds) all.push_back(&speed);
  const CarPosterior posterior(prior, all);
  const PosteriorMode mode = posterior_mode(posterior, Eigen::VectorXd::Zero(posterior.size()));
  EXPECT_TRUE(mode.converged);
  const ParameterVector found = posterior.parameters(mode.v);
  const ParameterVector truth = sim::draw_car(drive.scenario, kSeed, vehicle).parameters;
  double squares = 0.0;
  for (int p = kSpring; p < kTyreDamper; ++p) {
    const Eigen::Index at = posterior.place(p);
    const double sigma = prior.sigma(p) * std::sqrt(mode.covariance(at, at));
    const double error = std::log(found(p) / truth(p));
    std::printf("%s %2d: %+5.2f %% +- %4.2f\n", GetParam().name, p, 100.0 * error, 100.0 * sigma);
    EXPECT_LT(std::abs(error), 4.0 * sigma) << p;
    if (p < kTyre) continue;
    squares += error * error / (sigma * sigma);
    EXPECT_LT(std::abs(error), 0.03) << p;
  }
  std::printf("%s: %d steps, tyres' squares %.1f of 4\n", GetParam().name, mode.steps, squares);
  EXPECT_LT(squares, 18.5);  // chi^2 of four: one in a thousand
}

sim::RoadScenario road_of(double below, double above = 2.0, double bend_1_m = 0.0, double right = 0.0) {
  sim::RoadScenario road{16e-6, 0.3, 0.95};
  road.waviness = {.below = below, .above = bend_1_m > 0.0 ? above : below, .bend_1_m = bend_1_m};
  road.right_waviness = right;
  return road;
}

INSTANTIATE_TEST_SUITE_P(Roads, PosteriorOfADrive,
                         testing::Values(Case{"2.0", road_of(2.0)}, Case{"1.5", road_of(1.5)},
                                         Case{"2.5", road_of(2.5)},
                                         Case{"1.5 and 3 beyond 0.4", road_of(1.5, 3.0, 0.4)},
                                         Case{"1.6 left, 2.6 right", road_of(1.6, 1.6, 0.0, 1.0)}));

}  // namespace
}  // namespace roadbalance
