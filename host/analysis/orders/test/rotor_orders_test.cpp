#include "host/analysis/orders/rotor_orders.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "host/analysis/orders/test/synthetic_rotor.hpp"

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
  EXPECT_EQ(far.refusal(), "");
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

TEST(RotorOrders, ThatShareTheirRowsFindWhatEachFindsAlone) {
  const VehicleConfig vehicle = test::rotor_vehicle(1.0, {2, 3});
  const RotorOrders::Effort effort{.spectra = false, .least_rotation_hz = 6.0, .highest_hz = 40.0};
  const test::SyntheticDrive drive{.left_rad = left,
                                   .right_rad = right,
                                   .shaft_rad = left,
                                   .vector = {kNear, 0.0, kFar},
                                   .noise = 0.1,
                                   .silent_from_s = 15.0,
                                   .silent_to_s = 16.0};
  const auto orders = [&](int wheel, int node) {
    const auto place = static_cast<std::size_t>(wheel);
    return std::make_unique<RotorOrders>(vehicle, rotor_of(vehicle, vehicle.wheel[place]), node,
                                         std::vector<std::size_t>{0}, std::vector<double>{1.0}, effort);
  };
  for (const int node : {0, 1}) {
    const auto shares = orders(2, node), served = orders(3, node), alone_2 = orders(2, node),
               alone_3 = orders(3, node);
    ASSERT_TRUE(shares->can_share_with(*served));
    shares->share_with(*served);
    drive.seal_into([&](const SealedBlock& block) {
      shares->consume(block);
      alone_2->consume(block);
      alone_3->consume(block);
    });
    for (const auto& [one, alone] : {std::pair{shares.get(), alone_2.get()}, {served.get(), alone_3.get()}}) {
      const MeanVector &found = one->vectors().result(0, 0).all,
                       &expected = alone->vectors().result(0, 0).all;
      EXPECT_GT(expected.count(), 40);
      EXPECT_EQ(found.count(), expected.count());
      EXPECT_EQ(found.mean(), expected.mean());
      EXPECT_EQ(one->seconds().no_angle, alone->seconds().no_angle);
      EXPECT_EQ(one->gaps(), alone->gaps());
    }
  }
  EXPECT_FALSE(orders(2, 0)->can_share_with(*orders(2, 1)));
}

}  // namespace
}  // namespace roadbalance
