#include "host/analysis/identify/car_posterior.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "common/vehicle/contact_patch.hpp"
#include "host/analysis/identify/signals.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double kPi = std::numbers::pi;
constexpr double kWheelbase_m = 2.7;
constexpr Index kChannels = 8;

/// The car of the reference numbers with sensors on the carriers and at the strut tops.
CarPrior reference_car() {
  CarPrior prior;
  prior.geometry = {{1.25, 1.25, -1.45, -1.45}, {0.74, -0.74, 0.74, -0.74}};
  prior.value << 1300.0, 480.0, 2200.0, 34.0, 34.0, 32.0, 32.0, 22e3, 22e3, 24e3, 24e3, 1500.0, 1500.0,
      1600.0, 1600.0, 12e3, 5e3, 215e3, 215e3, 210e3, 210e3, 0.0, 0.0, 0.0, 0.0;
  prior.sigma << 0.03, 0.1, 0.1, 0.02, 0.02, 0.02, 0.02, 0.3, 0.3, 0.3, 0.3, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5,
      0.3, 0.3, 0.3, 0.3, 50.0, 50.0, 50.0, 50.0;
  prior.sensors = Eigen::MatrixXd::Zero(kChannels, kCoordinates);
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    prior.sensors(i, kBodyCoordinates + i) = 1.0;
    prior.sensors.row(kWheels + i).head<3>() << 1.0, prior.geometry.y_m[w], -prior.geometry.x_m[w];
  }
  prior.gain_sigma = VectorXd::Constant(kChannels, 0.01);
  prior.noise_m2_s4_hz = 1e-12;
  prior.delay_sigma = 0.02;
  return prior;
}

/// Rates of the struts by the channels, gains aside.
Eigen::MatrixXd strut_rates(const CarPrior& car) {
  const Eigen::MatrixXd normal = car.sensors.transpose() * car.sensors;
  return strut_stretch(car.geometry) * normal.llt().solve(car.sensors.transpose());
}

/// The exact spectra of a car's drive at one speed.
struct Drive {
  double speed_m_s = 30.0;
  double segments = 1e4;
  double exponent = 2.0;  ///< of the road on both sides
  double noise_m2_s4_hz = 1e-7;
  VectorXd gains = VectorXd::Ones(kChannels);
  /// The struts' signals: so many times their rates, and what has nothing to do with these.
  double friction_linear = 0.0, strut_rest = 0.0;
  double later = 1.0;  ///< the delay's factor: the rolling radius is smaller than was thought

  SpectralMoments of(const CarPrior& car, const ParameterVector& parameters) const {
    SpectralMoments moments;
    const Index bins = 158;
    moments.frequency_hz = Eigen::ArrayXd::LinSpaced(bins, 0.75, 40.0);
    moments.segments = segments;
    moments.delay_seconds = segments * kWheelbase_m / speed_m_s;
    moments.count.setConstant(bins, segments);
    const LinearModel model = linear_model(car.geometry, parameters);
    // Left and right correlate by 0.3, a rear wheel with its front wheel by 0.95.
    Eigen::Matrix4d level;
    level << 1.0, 0.3, 0.95, 0.285, 0.3, 1.0, 0.285, 0.95, 0.95, 0.285, 1.0, 0.3, 0.285, 0.95, 0.3, 1.0;
    for (Index k = 0; k < bins; ++k) {
      const double omega = moments.omega(k);
      const double n = omega / (2.0 * kPi * speed_m_s);
      const double density = 1e-6 * std::pow(n / 0.6, -exponent) / (1.0 + std::pow(n / kPatchWave_1_m, 2));
      const double delay_s = kWheelbase_m / speed_m_s;
      const Complex rear = std::polar(1.0, -omega * later * delay_s);
      const Eigen::Vector4cd delay(1.0, 1.0, rear, rear);
      const Eigen::Matrix4cd road =
          density * delay.asDiagonal() * level.cast<Complex>() * delay.conjugate().asDiagonal();
      const Eigen::Matrix<Complex, 7, 7> dynamic =
          model.Q.cast<Complex>() + kJ * omega * model.P - omega * omega * model.M;
      const Eigen::Matrix<Complex, 7, 4> response =
          -omega * omega * dynamic.inverse() * (model.S.cast<Complex>() + kJ * omega * model.Sd);
      const Eigen::MatrixXcd channels = gains.asDiagonal() * car.sensors.cast<Complex>() * response;
      Eigen::MatrixXcd spectrum = channels * road * channels.adjoint();
      spectrum.diagonal().array() += noise_m2_s4_hz;
      Eigen::MatrixXcd integral = Eigen::MatrixXcd::Zero(3 * kChannels + kStrutSignals, kChannels);
      integral.topRows(kChannels).setIdentity();
      integral.middleRows(kChannels, kChannels).diagonal().setConstant(1.0 / (kJ * omega));
      integral.middleRows(2 * kChannels, kChannels).diagonal().setConstant(-1.0 / (omega * omega));
      integral.middleRows(3 * kChannels, kWheels) = friction_linear / (kJ * omega) * strut_rates(car);
      moments.same.push_back(segments * integral * spectrum * integral.adjoint());
      moments.same.back().bottomRightCorner(kStrutSignals, kStrutSignals).diagonal().array() +=
          segments * strut_rest;
      moments.delayed.push_back(std::polar(1.0, -omega * delay_s) * moments.same.back());
    }
    return moments;
  }
};

/// Away from the mode, where nothing cancels.
VectorXd some_place(const CarPosterior& posterior) {
  VectorXd v(posterior.size());
  for (Index a = 0; a < v.size(); ++a) v(a) = 0.3 * std::sin(1.7 * static_cast<double>(a) + 0.4);
  return v;
}

void expect_gradient(const CarPrior& car, const SpectralMoments& slow, const SpectralMoments& fast,
                     int road_of_fast = 0) {
  CarPosterior posterior(car, {{&slow}, {&fast, road_of_fast}});
  const VectorXd v = some_place(posterior);
  posterior.linearise_struts(v);
  VectorXd gradient;
  EXPECT_DOUBLE_EQ(posterior.value(v, gradient), posterior.value(v));
  for (Index a = 0; a < v.size(); ++a) {
    const double h = 1e-3;
    const auto at = [&](double by) {
      VectorXd moved = v;
      moved(a) += by;
      return posterior.value(moved);
    };
    // Five points: the error is of order h^4.
    const double slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
    EXPECT_NEAR(gradient(a), slope, 1e-6 * (std::abs(slope) + 1e-3 * gradient.cwiseAbs().maxCoeff())) << a;
  }
}

/// Whose struts may have friction and be harder in rebound, as far as the prior goes.
CarPrior car_with_any_struts() {
  CarPrior car = reference_car();
  car.friction_sigma_n = 50.0;
  car.rebound_sigma = 0.5;
  car.strut_sigma = 0.2;
  car.bracket_sigma_s2 = 5e-5;
  return car;
}
const Drive kStruts{.friction_linear = 20.0, .strut_rest = 1e-3};
const Drive kFasterStruts{.speed_m_s = 33.0, .friction_linear = 20.0, .strut_rest = 1e-3};

TEST(CarPosterior, GradientIsTheDerivativeOfItsValue) {
  const CarPrior car = reference_car();
  expect_gradient(car, Drive{.speed_m_s = 25.0}.of(car, car.value),
                  Drive{.speed_m_s = 33.0}.of(car, car.value));
}

TEST(CarPosterior, GradientIsTheDerivativeOfItsValueOnTwoRoads) {
  const CarPrior car = reference_car();
  expect_gradient(car, Drive{.speed_m_s = 25.0}.of(car, car.value),
                  Drive{.speed_m_s = 33.0, .exponent = 2.7}.of(car, car.value), 1);
}

TEST(CarPosterior, GradientIsTheDerivativeOfItsValueWhereStrutsAreNotLinear) {
  const CarPrior car = car_with_any_struts();
  expect_gradient(car, kStruts.of(car, car.value), kFasterStruts.of(car, car.value));
}

// The struts of the exact drive do as their rates say and no more: friction is then a damper, and whatever is
// not of the rates shows that there is none.
TEST(CarPosterior, FrictionThatIsNotThereIsNotFound) {
  const CarPrior car = car_with_any_struts();
  const SpectralMoments slow = kStruts.of(car, car.value), fast = kFasterStruts.of(car, car.value);
  CarPosterior posterior(car, {{&slow}, {&fast}});
  posterior.linearise_struts(VectorXd::Zero(posterior.size()));
  const PosteriorMode mode = posterior_mode(posterior, VectorXd::Zero(posterior.size()));
  EXPECT_TRUE(mode.converged);
  EXPECT_LT(posterior.friction_n(mode.v).cwiseAbs().maxCoeff(), 1.0);
  EXPECT_LT(posterior.rebound(mode.v).cwiseAbs().maxCoeff(), 0.01);
}

// Fisher's information is the second derivative of the expected log likelihood, which exact spectra give.
void expect_curvature(int road_of_fast) {
  const CarPrior car = reference_car();
  const SpectralMoments slow = Drive{.speed_m_s = 25.0}.of(car, car.value);
  const SpectralMoments fast = Drive{.speed_m_s = 33.0}.of(car, car.value);
  const CarPosterior posterior(car, {{&slow}, {&fast, road_of_fast}});
  const VectorXd truth = VectorXd::Zero(posterior.size());
  const Eigen::MatrixXd information = posterior.information(truth);
  const VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd curvature(truth.size(), truth.size());
  for (Index a = 0; a < truth.size(); ++a) {
    VectorXd above, below;
    const VectorXd step = VectorXd::Unit(truth.size(), a) * 0.01 * scale(a);
    posterior.value(truth + step, above);
    posterior.value(truth - step, below);
    curvature.col(a) = (above - below) / (0.02 * scale(a));
  }
  const Eigen::MatrixXd difference = scale.asDiagonal() * (curvature - information) * scale.asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 0.02);
  // At the truth nothing pulls: in standard deviations.
  VectorXd gradient;
  posterior.value(truth, gradient);
  const VectorXd pull = information.llt().matrixL().solve(gradient);
  EXPECT_LT(pull.norm(), 0.3);
}

TEST(CarPosterior, InformationIsTheCurvatureAtTheTruth) {
  expect_curvature(0);
}

TEST(CarPosterior, InformationIsTheCurvatureAtTheTruthOfTwoRoads) {
  expect_curvature(1);
}

TEST(CarPosterior, ModeIsTheTruthWhereThePriorIsFarOff) {
  CarPrior car = reference_car();
  ParameterVector truth = car.value;
  truth(kRollInertia) *= 1.15;
  truth(kPitchInertia) *= 0.9;
  truth.segment<4>(kSpring) *= 1.2;
  truth.segment<4>(kDamper) *= 0.8;
  truth(kTyre) *= 1.1;
  truth(kTyre + 3) *= 0.9;
  truth(kTyreDamper + 1) = 60.0;
  Drive drive{.segments = 1e6, .exponent = 2.6};
  drive.gains(2) = 1.015;
  drive.gains(5) = 0.99;
  const SpectralMoments slow = (drive.speed_m_s = 25.0, drive).of(car, truth);
  const SpectralMoments fast = (drive.speed_m_s = 34.0, drive).of(car, truth);
  const CarPosterior posterior(car, {{&slow}, {&fast}});
  const PosteriorMode mode = posterior_mode(posterior, VectorXd::Zero(posterior.size()));
  EXPECT_TRUE(mode.converged);
  EXPECT_LE(mode.steps, 15);
  const ParameterVector found = posterior.parameters(mode.v);
  const VectorXd gains = posterior.gains(mode.v);
  // Only ratios leave a trace: of all masses and stiffnesses, and of all gains.
  const double masses = found(kBodyMass) / truth(kBodyMass);
  for (int p = 0; p < kTyreDamper; ++p) EXPECT_NEAR(found(p) / truth(p) / masses, 1.0, 0.003) << p;
  EXPECT_NEAR(found(kTyreDamper + 1), 60.0, 3.0);
  for (Index c = 0; c < kChannels; ++c)
    EXPECT_NEAR(gains(c) / gains(0) / (drive.gains(c) / drive.gains(0)), 1.0, 5e-4) << c;
  // The scale of masses is known by its prior alone: 25 parameters of which each mass has its own sigma.
  EXPECT_GT(mode.covariance(posterior.place(kBodyMass), posterior.place(kBodyMass)), 0.05);
}

// 0.5 % are 0.04 rad between front and rear at 12 Hz, where their coherence tells 0.002 rad.
TEST(CarPosterior, ADelayThatIsLongerIsFoundAndMovesNothing) {
  const CarPrior car = reference_car();
  const Drive slowly{.speed_m_s = 25.0, .segments = 1e6, .later = 1.005};
  const Drive fast{.speed_m_s = 34.0, .segments = 1e6, .later = 1.005};
  const SpectralMoments at_25 = slowly.of(car, car.value), at_34 = fast.of(car, car.value);
  const auto tyres_off = [&](const CarPosterior& posterior, const PosteriorMode& mode) {
    const Eigen::Vector4d known = car.value.segment<kWheels>(kTyre);
    const Eigen::Vector4d found = posterior.parameters(mode.v).segment<kWheels>(kTyre);
    return (found.cwiseQuotient(known) - Eigen::Vector4d::Ones()).cwiseAbs().maxCoeff();
  };
  const std::vector<SpeedOnRoad> speeds{{&at_25}, {&at_34}};
  const CarPosterior posterior(car, speeds);
  const PosteriorMode mode = posterior_mode(posterior, VectorXd::Zero(posterior.size()));
  EXPECT_TRUE(mode.converged);
  EXPECT_LT(tyres_off(posterior, mode), 0.002);
  EXPECT_NEAR(posterior.delay_share(mode.v, 0), 0.005, 2e-4);
  EXPECT_NEAR(posterior.delay_share(mode.v, 1), 0.005, 2e-4);

  CarPrior certain = car;
  certain.delay_sigma = 0.0;
  const CarPosterior of_certain(certain, speeds);
  const PosteriorMode wrong = posterior_mode(of_certain, VectorXd::Zero(of_certain.size()));
  EXPECT_GT(tyres_off(of_certain, wrong), 0.005) << "it does move the tyres of who takes it for known";
}

TEST(CarPosterior, ARoadOfAnotherExponentMovesNothing) {
  const CarPrior car = reference_car();
  const auto tyres = [&](double exponent) {
    const SpectralMoments moments = Drive{.segments = 1e6, .exponent = exponent}.of(car, car.value);
    const CarPosterior posterior(car, {{&moments}});
    const PosteriorMode mode = posterior_mode(posterior, VectorXd::Zero(posterior.size()));
    return posterior.parameters(mode.v).segment<kWheels>(kTyre).eval();
  };
  // By the likelihood of exponent 2 it would be 5 % for each 0.15.
  EXPECT_LT((tyres(1.6).cwiseQuotient(car.value.segment<kWheels>(kTyre)) - Eigen::Vector4d::Ones()).norm(),
            0.004);
}

}  // namespace
}  // namespace roadbalance
