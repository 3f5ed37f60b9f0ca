#include "host/analysis/orders/rotor.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {
namespace {

TEST(Rotor, AngleIsKnownModuloTheShareThatATurnOfAWheelMayAdd) {
  EXPECT_EQ(known_share(1.0, 1), 1.0);
  EXPECT_EQ(known_share(3.0, 1), 1.0);
  EXPECT_EQ(known_share(3.5, 1), 0.5);
  EXPECT_EQ(known_share(4.0, 2), 1.0) << "a wheel's turn is two of the rotor";
  EXPECT_EQ(known_share(3.0, 2), 0.5);
  EXPECT_NEAR(known_share(41.0 / 11.0, 1), 1.0 / 11.0, 1e-15);
  EXPECT_NEAR(known_share(3.7272727273, 1), 1.0 / 11.0, 1e-15) << "as somebody types it";
  EXPECT_NEAR(known_share(41.0 / 11.0, 2), 1.0 / 22.0, 1e-15);
  EXPECT_NEAR(known_share(3.73, 1), 0.01, 1e-15) << "taken at its word";
  EXPECT_EQ(known_share(std::numbers::pi, 1), 0.0);
}

/// Tries the claim of known_share: all turns that each wheel may have made put the rotor there.
TEST(Rotor, StandsInAsManyPlacesAsWheelsMayHaveTurned) {
  for (const auto& [ratio, wheels] : {std::pair{4.0, 2}, {3.0, 2}, {41.0 / 11.0, 1}, {10.0 / 3.0, 2}}) {
    const double share = known_share(ratio, wheels);
    for (int turns = -50; turns <= 50; ++turns) {
      const double moved = ratio / wheels * turns / share;  // one wheel more or less, in shares
      EXPECT_NEAR(moved, std::round(moved), 1e-6) << ratio << " " << turns;
    }
  }
}

TEST(Rotor, WithoutAZeroMarkIsOnlyCounted) {
  VehicleConfig vehicle{};
  for (auto& wheel : vehicle.wheel) wheel.rolling_radius_m = 0.3;
  vehicle.drive.speed_class_m_s = 2.0;
  EXPECT_EQ(rotor_of(vehicle, vehicle.wheel[2]).known_share, 1.0);
  const RotorConfig shaft{.name = "shaft", .wheel = {2, 3}, .ratio = 4.0, .plane = {}};
  EXPECT_EQ(rotor_of(vehicle, shaft).known_share, 1.0);
  EXPECT_NEAR(rotor_of(vehicle, shaft).way_m(vehicle), 2 * std::numbers::pi * 0.3 / 4.0, 1e-12);
  EXPECT_NEAR(rotor_of(vehicle, shaft).class_hz(vehicle), 2.0 * 4.0 / (2 * std::numbers::pi * 0.3), 1e-12);
  vehicle.wheel[3].encoder.zero_mark = false;
  EXPECT_EQ(rotor_of(vehicle, vehicle.wheel[3]).known_share, 0.0);
  EXPECT_EQ(rotor_of(vehicle, shaft).known_share, 0.0);
}

}  // namespace
}  // namespace roadbalance
