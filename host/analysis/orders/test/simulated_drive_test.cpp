// A drive of the simulated car, sealed as its front node would, through RotorOrders.  The motion of the wheel
// carrier under an unbalance is computed beside it: (M + P / jw - Q / w^2) z'' = W F.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <cstdio>
#include <fstream>
#include <numbers>

#include "common/bus/codec.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "common/vehicle/linear_model.hpp"
#include "firmware/epoch_packer.hpp"
#include "host/analysis/orders/order_peaks.hpp"
#include "host/analysis/orders/rotor_orders.hpp"
#include "sim/front_end.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kSpeed_m_s = 108.0 / 3.6;

const VehicleConfig& vehicle() {
  static const VehicleConfig demo = VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "demo");
  return demo;
}

/// Vertical acceleration of the front left carrier per unit of first-order phasor of its own wheel's angle.
Complex expected_acceleration(double unbalance_kg_m, double angle_rad) {
  const LinearModel model = linear_model(geometry_of(vehicle().model), nominal_parameters(vehicle()));
  const double omega = kSpeed_m_s / vehicle().wheel[0].rolling_radius_m;
  const Eigen::Matrix<Complex, kCoordinates, kCoordinates> dynamic =
      model.M.cast<Complex>() + model.P / Complex(0.0, omega) - model.Q.cast<Complex>() / (omega * omega);
  const Complex force = std::polar(unbalance_kg_m * omega * omega, angle_rad);
  return (dynamic.inverse() * model.W.col(0).cast<Complex>())(kBodyCoordinates)*force;
}

/// 25 g at 75 degrees on the front left wheel of a car that is exactly as in vehicle.toml.
std::string scenario(const std::string& road, double noise_m_s2) {
  return "[drive]\nwander_km_h = 0.0\n[[drive.plateau]]\nspeed_km_h = 108.0\nseconds = 60.0\n"
         "[road]\nclass = \"" +
         road +
         "\"\n"
         "[[unbalance]]\nwheel = \"front_left\"\nmass_g = 25.0\nangle_deg = 75.0\n"
         "[spread]\nparameters = 0.0\nrolling_radius = 0.0\n"
         "[sensor]\nnoise_m_s2 = " +
         std::to_string(noise_m_s2) +
         "\ncoupling_from_vertical = 0.0\ncoupling_into_vertical = 0.0\n"
         "[encoder]\npitch_error_pitches = 0.0\nstamp_jitter_us = 0.0\n";
}

class SimulatedDrive : public testing::Test {
 protected:
  RotorOrders orders_{vehicle(), rotor_of(vehicle(), vehicle().wheel[0]), 0, {2}, {1.0, 2.0}};

  void drive(const std::string& text, const std::function<void(const SealedBlock&)>& take) {
    std::ofstream(folder_ / "scenario.toml") << text;
    const NodeConfig& node = vehicle().node_named("front");
    ASSERT_EQ(node.channel[2].name, "fl_carrier_z");
    const auto front_end =
        sim::open_sim_front_end({folder_ / "scenario.toml?seed=5&rate=max", vehicle(), node});
    pack_epoch(*front_end, vehicle(), node, 1, take);
  }
  void drive(const std::string& text) {
    drive(text, [&](const SealedBlock& block) { orders_.consume(block); });
  }

  const test::TemporaryDirectory folder_;
  const Complex expected_ = expected_acceleration(0.025 * vehicle().wheel[0].weight_radius_m, 75.0 * kDegree);
};

TEST_F(SimulatedDrive, FirstOrderOfTheCarrierIsThatOfTheory) {
  drive(scenario("none", 0.001));
  const MeanVector first = orders_.vectors().result(0, 0).all;
  const auto confidence = first.confidence();
  ASSERT_TRUE(confidence && confidence->phase_rad);
  // 1060 turns but for the node's learning of its ring.
  EXPECT_GT(first.count(), 110);
  std::printf("amplitude off by %+.4f %%, phase by %+.4f degrees\n",
              100.0 * (std::abs(first.mean() / expected_) - 1.0),
              std::arg(first.mean() / expected_) / kDegree);
  // The simulated filter's gain is 6e-5 short, the low-pass 2e-4; ENCODER.md of the rings: 0.01 degrees.
  EXPECT_NEAR(std::abs(first.mean() / expected_), 1.0, 1e-3);
  EXPECT_NEAR(std::arg(first.mean() / expected_) / kDegree, 0.0, 0.02);
  const auto peaks = find_peaks(orders_.waterfall().spectrum(0), 5);
  ASSERT_EQ(peaks.size(), 1U);
  EXPECT_NEAR(peaks[0].order, 1.0, 1e-3);
  EXPECT_NEAR(peaks[0].amplitude, std::abs(expected_), 2e-3 * std::abs(expected_));
}

TEST_F(SimulatedDrive, OnARoadTheTruthIsWithinTheConfidence) {
  drive(scenario("A", 0.02));
  const auto first = orders_.vectors().result(0, 0).all;
  const auto confidence = first.confidence();
  ASSERT_TRUE(confidence && confidence->phase_rad);
  std::printf("%.4f +- %.4f of %.4f, %.2f +- %.2f of %.2f degrees\n", std::abs(first.mean()),
              confidence->amplitude, std::abs(expected_), std::arg(first.mean()) / kDegree,
              *confidence->phase_rad / kDegree, std::arg(expected_) / kDegree);
  const Complex off = first.mean() - expected_;
  const Eigen::Vector2d d(off.real(), off.imag());
  EXPECT_LT(d.dot(confidence->covariance.inverse() * d), 1.5 * confidence->limit);
  // The road is of the same size, and the statement is no empty one.
  EXPECT_LT(confidence->amplitude, 0.5 * std::abs(expected_));
  // The car has no second order.
  const auto second = orders_.vectors().result(0, 1).all;
  EXPECT_LT(std::abs(second.mean()), 1.5 * second.confidence()->amplitude);
}

TEST_F(SimulatedDrive, LostScansAndAnUncertainAngleInterruptAndDoNotBias) {
  int number = 0, lost = 0;
  drive(scenario("none", 0.001), [&](const SealedBlock& block) {
    if (block.kind == BlockKind::kScan && ++number % 500 == 0) {  // every 5 s
      ++lost;
      return;
    }
    if (block.kind == BlockKind::kScan && number % 500 == 250) {
      ScanBlock spoilt = decode_scan(block);
      spoilt.quality |= kQualityUncertainAngle0;
      for (auto& row : spoilt.counts) row[kAccelerations] = row[kAccelerations + 1] = 5'000'000;
      SealedBlock sealed;
      seal(spoilt, sealed);
      return orders_.consume(sealed);
    }
    orders_.consume(block);
  });
  EXPECT_GT(lost, 8);
  EXPECT_GE(orders_.gaps(), lost - 1);
  EXPECT_GT(orders_.seconds().uncertain, 0.05);
  const MeanVector first = orders_.vectors().result(0, 0).all;
  EXPECT_GT(first.count(), 70);
  EXPECT_NEAR(std::abs(first.mean() / expected_), 1.0, 1e-3);
  EXPECT_NEAR(std::arg(first.mean() / expected_) / kDegree, 0.0, 0.02);
}

}  // namespace
}  // namespace roadbalance
