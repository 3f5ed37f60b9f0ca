#include "host/orders/rotor_orders.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "host/orders/test/synthetic_rotor.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;
constexpr double kDegree = pi / 180.0;
const Complex kNear = std::polar(1.5, 40.0 * kDegree), kFar = std::polar(0.3, -110.0 * kDegree);

double left(double t) {
  return 2 * pi * (11.0 * t + 0.02 * t * t) + 0.3;
}
double right(double t) {
  return left(t) + 0.4 * t + 1.0;  // a bend
}

struct Found {
  MeanVector near, far;
  bool has_phase;
  RotorOrders::Seconds seconds;
};

Found drive(double ratio, std::vector<int> wheels, double order, double silent_from_s = 1e9,
            double silent_to_s = 1e9) {
  const VehicleConfig vehicle = test::rotor_vehicle(ratio, wheels);
  const auto turned = [&](double t) {
    return ratio * (wheels.size() == 2 ? 0.5 * (left(t) + right(t)) : left(t));
  };
  const test::SyntheticDrive drive{.left_rad = left,
                                   .right_rad = right,
                                   .shaft_rad = [&](double t) { return order * turned(t); },
                                   .vector = {kNear, 0.0, kFar},
                                   .silent_from_s = silent_from_s,
                                   .silent_to_s = silent_to_s};
  const Rotor rotor = rotor_of(vehicle, vehicle.rotor[0]);
  RotorOrders near(vehicle, rotor, 0, {0}, {order}), far(vehicle, rotor, 1, {0}, {order});
  drive.seal_into([&](const SealedBlock& block) {
    near.consume(block);
    far.consume(block);
  });
  EXPECT_EQ(far.obstacle(), "");
  return {near.vectors().result(0, 0).all, far.vectors().result(0, 0).all, near.vectors().has_phase(0),
          near.seconds()};
}

TEST(RotorOrders, HaveAmplitudeAndPhaseOfWhatTurnsWithTheMeanOfTwoWheels) {
  // 1000 Hz hold 0.38 of that: the shaft's 44 to 51 turns a second are far below.
  const Found found = drive(4.0, {2, 3}, 1.0, 15.0, 16.0);
  EXPECT_TRUE(found.has_phase);
  EXPECT_NEAR(found.seconds.no_angle, 1.0, 0.03);
  EXPECT_GT(found.near.count(), 150);
  EXPECT_LT(std::abs(found.near.mean() / kNear - 1.0), 2e-3) << "before and behind a hole alike";
  EXPECT_LT(std::abs(found.far.mean() / kFar - 1.0), 2e-3) << "a channel of another node";
}

TEST(RotorOrders, OfARotorKnownModuloHalfATurnCountFromTheRun) {
  const Found first = drive(3.5, {2}, 1.0, 15.0, 16.0), second = drive(3.5, {2}, 2.0, 15.0, 16.0);
  EXPECT_FALSE(first.has_phase);
  EXPECT_NEAR(std::abs(first.near.mean()) / std::abs(kNear), 1.0, 2e-3) << "of one run: nothing cancels";
  EXPECT_TRUE(second.has_phase) << "twice half a turn is a whole one";
  EXPECT_LT(std::abs(second.near.mean() / kNear - 1.0), 2e-3);
}

}  // namespace
}  // namespace roadbalance
