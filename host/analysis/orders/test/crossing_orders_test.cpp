#include "host/analysis/orders/crossing_orders.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "host/analysis/orders/rotor_orders.hpp"
#include "host/analysis/orders/test/synthetic_rotor.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;
const Complex kLeft = std::polar(1.0, 0.7), kRight = std::polar(0.6, -1.9);

// Turns a second: 12 to 16 and 16 to 12 in 40 s; they cross at 14.
double rising(double t) {
  return 2 * pi * (12.0 * t + 0.05 * t * t) + 0.3;
}
double falling(double t) {
  return 2 * pi * (16.0 * t - 0.05 * t * t) + 1.0;
}

VehicleConfig vehicle() {
  return test::rotor_vehicle(1.0, {2});
}

std::vector<Rotor> wheels(const VehicleConfig& car) {
  return {rotor_of(car, car.wheel[2]), rotor_of(car, car.wheel[3])};
}

test::SyntheticDrive crossing_drive() {
  return {.left_rad = rising,
          .right_rad = falling,
          .shaft_rad = rising,
          .vector = {kLeft, 0.0, 0.5 * kLeft},
          .noise = 0.2,
          .beside_rad = falling,
          .beside = {kRight, kRight, 0.0}};
}

Complex in_class(const std::map<int, MeanVector>& by_speed, int place) {
  return by_speed.at(place).mean();
}

TEST(CrossingOrders, AreToldApartWhereBlocksOfTurnsAreNot) {
  const VehicleConfig car = vehicle();
  CrossingOrders together(car, wheels(car), 0, {0, 1}, {1.0}, 1.0);
  RotorOrders alone(car, wheels(car)[0], 0, {0}, {1.0});
  crossing_drive().seal_into([&](const SealedBlock& block) {
    together.consume(block);
    alone.consume(block);
  });
  together.finish();
  const auto* left = together.find("rear_left", 0, 1.0);
  const auto* right = together.find("rear_right", 0, 1.0);
  ASSERT_TRUE(left && right);
  EXPECT_LT(std::abs(left->all.mean() - kLeft), 0.02);
  EXPECT_LT(std::abs(right->all.mean() - kRight), 0.02);
  EXPECT_LT(std::abs(together.find("rear_left", 1, 1.0)->all.mean()), 0.02)
      << "channel b has the right one only";
  EXPECT_EQ(together.find("rear_left", 2, 1.0), nullptr);
  // Their phases turn by less than half a turn in 2 s while they are nearer than 0.25 Hz: 2.5 s.
  EXPECT_NEAR(left->together_s, 2.5, 1.1);
  EXPECT_GT(left->used_s, 30.0);

  // The class about 14 turns a second, in which they cross.
  const double class_hz = together.class_hz("rear_left");
  const auto place = static_cast<int>(14.0 / class_hz);
  const auto blocks = alone.vectors().result(0, 0).by_speed;
  double worst = 0.0;
  for (const auto& of : blocks)
    if (of.from_hz <= 14.5 && of.to_hz >= 13.5) worst = std::max(worst, std::abs(of.vector.mean() - kLeft));
  EXPECT_GT(worst, 0.05) << "a block of turns cannot";
  EXPECT_LT(std::abs(in_class(left->by_speed, place) - kLeft), 0.03);

  const auto confidence = left->all.confidence();
  ASSERT_TRUE(confidence);
  const Complex off = left->all.mean() - kLeft;
  const Eigen::Vector2d d(off.real(), off.imag());
  EXPECT_LT(d.dot(confidence->covariance.inverse() * d), 2.0 * confidence->limit);
}

TEST(CrossingOrders, OfANodeThatReadsNoEncoderAreTheSame) {
  const VehicleConfig car = vehicle();
  CrossingOrders far(car, wheels(car), 1, {0}, {1.0}, 1.0);
  crossing_drive().seal_into([&](const SealedBlock& block) { far.consume(block); });
  far.finish();
  EXPECT_LT(std::abs(far.find("rear_left", 0, 1.0)->all.mean() - 0.5 * kLeft), 0.02);
}

TEST(CrossingOrders, ThatStayTogetherAreNotTold) {
  const VehicleConfig car = vehicle();
  CrossingOrders together(car, wheels(car), 0, {0}, {1.0}, 1.0);
  test::SyntheticDrive drive = crossing_drive();
  drive.right_rad = drive.beside_rad = [](double t) { return rising(t) + 1.0; };
  drive.seal_into([&](const SealedBlock& block) { together.consume(block); });
  together.finish();
  EXPECT_EQ(together.find("rear_left", 0, 1.0)->all.count(), 0);
  EXPECT_GT(together.find("rear_left", 0, 1.0)->together_s, 30.0);
}

TEST(CrossingOrders, AHoleEndsARunAndNothingReachesAcross) {
  const VehicleConfig car = vehicle();
  CrossingOrders together(car, wheels(car), 0, {0}, {1.0}, 1.0);
  test::SyntheticDrive drive = crossing_drive();
  drive.silent_from_s = 15.0;
  drive.silent_to_s = 25.0;
  drive.seal_into([&](const SealedBlock& block) { together.consume(block); });
  together.finish();
  const auto* left = together.find("rear_left", 0, 1.0);
  EXPECT_LT(left->used_s, 30.0);
  EXPECT_GT(left->used_s, 22.0);
  EXPECT_LT(std::abs(left->all.mean() - kLeft), 0.02);
}

TEST(CrossingOrders, RefuseWhatCannotBe) {
  const VehicleConfig car = vehicle();
  EXPECT_THROW(CrossingOrders(car, wheels(car), 0, {0}, {0.5}, 1.0), std::invalid_argument)
      << "no lasting phase";
  EXPECT_THROW(CrossingOrders(car, wheels(car), 0, {0}, {20.0}, 1.0), std::invalid_argument) << "too high";
  EXPECT_THROW(CrossingOrders(car, wheels(car), 0, {0}, {1.0}, 0.01), std::invalid_argument) << "bandwidth";
  EXPECT_THROW(CrossingOrders(car, wheels(car), 0, {0}, {1, 2, 3, 4, 5, 6, 7}, 1.0), std::invalid_argument);
  EXPECT_THROW(CrossingOrders(car, {}, 0, {0}, {1.0}, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
