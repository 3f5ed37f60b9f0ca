#include "host/analysis/orders/same_rotor.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "host/analysis/orders/test/synthetic_rotor.hpp"

namespace roadbalance {
namespace {

TEST(SameRotor, IsOneWhoseDatumAloneDiffers) {
  const VehicleConfig one = test::rotor_vehicle(4.0, {2, 3});
  EXPECT_EQ(difference(one, one, "shaft"), "");
  VehicleConfig other = one;
  other.wheel[2].encoder.datum_rad = 0.3;
  EXPECT_EQ(difference(one, other, "shaft"), "");
  // Half of a wheel's angle, times four.
  EXPECT_NEAR(datum_of(other, other.rotor[0]) - datum_of(one, one.rotor[0]), 0.6, 1e-12);
}

TEST(SameRotor, NamesWhatForbidsToCompare) {
  const VehicleConfig one = test::rotor_vehicle(4.0, {2});
  const auto difference = [&](const std::function<void(VehicleConfig&)>& change) {
    VehicleConfig other = one;
    change(other);
    return roadbalance::difference(one, other, "shaft");
  };
  EXPECT_EQ(difference([](VehicleConfig& v) { v.rotor[0].ratio = 4.1; }),
            "ratio of shaft is 4 in one and 4.1 in the other");
  EXPECT_EQ(difference([](VehicleConfig& v) { v.rotor[0].wheel = {3}; }),
            "wheel of shaft is rear_left in one and rear_right in the other");
  EXPECT_NE(difference([](VehicleConfig& v) { v.rotor[0].plane.pop_back(); }), "");
  EXPECT_NE(difference([](VehicleConfig& v) { v.rotor[0].plane[1].name = "rear"; }).find("back"),
            std::string::npos);
  EXPECT_NE(difference([](VehicleConfig& v) {
              v.rotor[0].plane[1].weight_radius_m = 0.06;
            }).find("weight_radius_m"),
            std::string::npos);
  EXPECT_NE(difference([](VehicleConfig& v) {
              v.wheel[2].rolling_radius_m = 0.31;
            }).find("rolling_radius_m of rear_left"),
            std::string::npos)
      << "classes of speed are counted in turns";
  EXPECT_EQ(difference([](VehicleConfig& v) { v.wheel[3].rolling_radius_m = 0.31; }), "")
      << "it does not turn it";
  EXPECT_NE(difference([](VehicleConfig& v) { v.drive.speed_class_m_s = 3.0; }).find("speed_class_m_s"),
            std::string::npos);
}

}  // namespace
}  // namespace roadbalance
