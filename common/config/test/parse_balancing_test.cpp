#include "common/config/parse_balancing.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "common/config/test/refusal.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::string demo() {
  return test::read_source("sim/demo/vehicle.toml");
}

/// The demo car, its front left wheel with these lines too.
std::string with_wheel(const std::string& keys, const std::string& table = "") {
  std::string text = demo();
  const std::string radius = "weight_radius_m = 0.19\n", datum = "datum_deg = 30\n";
  text.insert(text.find(radius) + radius.size(), keys);
  return text.insert(text.find(datum) + datum.size(), table);
}

VehicleConfig car(const std::string& text) {
  return VehicleConfig::parse(text, "car.toml");
}

TEST(Balancing, NeedsNoWordsForStepsOfFiveGramsAnywhereAtTheWeightRadius) {
  const VehicleConfig vehicle = car(demo());
  for (const WheelConfig& wheel : vehicle.wheel) {
    EXPECT_EQ(wheel.stock.step_g, 5.0);
    EXPECT_EQ(wheel.stock.most, 2);
    EXPECT_EQ(wheel.stock.raster_rad, 0.0);
    EXPECT_EQ(wheel.stock.radius_m, std::vector{wheel.weight_radius_m});
    EXPECT_TRUE(wheel.fitted.empty());
  }
  EXPECT_EQ(vehicle.limits.shop_g, 7.0);
  EXPECT_EQ(vehicle.limits.grade_mm_s, 40.0);
  EXPECT_TRUE(vehicle.seat.empty());
}

TEST(Balancing, TakesWhatWeightsAndPlacesThereAre) {
  const VehicleConfig vehicle =
      car(with_wheel("weight_radii_m = [0.19, 0.16]\n",
                     "[[wheel.weight]]\nmass_g = 20\nangle_deg = 45\n"
                     "[[wheel.weight]]\nmass_g = 5\nangle_deg = -90\nradius_m = 0.16\n") +
          "\n[weights]\nstep_g = 7.5\nheaviest_g = 45\nmost = 1\nraster_deg = 7.5\nlength_mm_per_g = 0.5\n"
          "[limits]\nshop_g = 5\ngrade_mm_s = 16\nheaviest_g = 80\nforce_n = 50\nsigma_g = 3\n"
          "[[seat]]\nname = \"driver\"\nposition_m = [0.1, 0.4, 0.2]\n"
          "[[seat]]\nname = \"behind\"\nposition_m = [-0.9, 0.4, 0.2]\nweight = 0.25\n");
  const WheelConfig& wheel = vehicle.wheel[0];
  EXPECT_EQ(wheel.stock.step_g, 7.5);
  EXPECT_EQ(wheel.stock.heaviest_g, 45.0);
  EXPECT_EQ(wheel.stock.most, 1);
  EXPECT_NEAR(wheel.stock.raster_rad, 7.5 * kDegree, 1e-15);
  EXPECT_NEAR(wheel.stock.length_m_per_g, 5e-4, 1e-15);
  EXPECT_EQ(wheel.stock.radius_m, (std::vector{0.19, 0.16}));
  EXPECT_EQ(vehicle.wheel[1].stock.radius_m, std::vector{0.19});
  EXPECT_EQ(vehicle.wheel[1].stock.step_g, 7.5);
  ASSERT_EQ(wheel.fitted.size(), 2U);
  EXPECT_EQ(wheel.fitted[0].mass_g, 20.0);
  EXPECT_EQ(wheel.fitted[0].radius_m, 0.19);
  EXPECT_NEAR(wheel.fitted[1].angle_rad, -90.0 * kDegree, 1e-15);
  EXPECT_EQ(wheel.fitted[1].radius_m, 0.16);
  EXPECT_EQ(vehicle.limits.shop_g, 5.0);
  EXPECT_EQ(vehicle.limits.grade_mm_s, 16.0);
  EXPECT_EQ(vehicle.limits.heaviest_g, 80.0);
  EXPECT_EQ(vehicle.limits.force_n, 50.0);
  EXPECT_EQ(vehicle.limits.sigma_g, 3.0);
  ASSERT_EQ(vehicle.seat.size(), 2U);
  EXPECT_EQ(vehicle.seat[0].weight, 1.0);
  EXPECT_EQ(vehicle.seat[1].position_m, Eigen::Vector3d(-0.9, 0.4, 0.2));
  EXPECT_EQ(vehicle.seat[1].weight, 0.25);
}

TEST(Balancing, NamesTheKeyThatCannotBe) {
  const auto refuses = [](const std::string& text, const std::string& at, const std::string& says) {
    test::expect_refusal(text, 0, at, says);
  };
  const auto stock = [](const std::string& keys) { return demo() + "\n[weights]\n" + keys + "\n"; };
  refuses(stock("step = 5"), "step = 5", "step: unknown key (did you mean step_g?)");
  refuses(stock("step_g = 0"), "step_g = 0", "step_g: is 0; allowed");
  refuses(stock("heaviest_g = 4"), "heaviest_g = 4", "heaviest_g: allowed: step_g .. 100 times step_g");
  refuses(stock("step_g = 0.5"), "[weights]", "heaviest_g: allowed: step_g .. 100 times step_g");
  refuses(stock("most = 3"), "most = 3", "most: is 3; allowed: an integer 1 .. 2");
  refuses(stock("raster_deg = 7"), "raster_deg = 7", "raster_deg: allowed: 0, or a part of 360");
  refuses(stock("raster_deg = 0.5"), "raster_deg = 0.5", "raster_deg: allowed: 0, or a part of 360");
  refuses(with_wheel("weight_radii_m = [0.19, 0.3]\n"), "weight_radii_m",
          "weight_radii_m: must be less than rolling_radius_m");
  refuses(with_wheel("weight_radii_m = [0.1, 0.12, 0.14, 0.16, 0.18]\n"), "weight_radii_m",
          "weight_radii_m: has 5 radii; allowed: at most 4");
  const std::string three = with_wheel("weight_radii_m = [0.1, 0.12, 0.14]\n") + "\n[weights]\nstep_g = 1\n";
  refuses(three + "heaviest_g = 67\n", "weight_radii_m",
          "weight_radii_m: with 67 masses on each radius; allowed: at most 200 choices");
  EXPECT_EQ(test::refusal(three + "heaviest_g = 66\n"), "accepted");
  refuses(with_wheel("", "[[wheel.weight]]\nmass_g = 20\n"), "[[wheel.weight]]", "angle_deg: missing");
  refuses(with_wheel("", "[[wheel.weight]]\nmass_g = 20\nangle_deg = 0\nradius_m = 0.3\n"),
          "\nradius_m = 0.3", "radius_m: must be less than rolling_radius_m");
  std::string many;
  for (int k = 0; k < 9; ++k) many += "[[wheel.weight]]\nmass_g = 5\nangle_deg = 0\n";
  EXPECT_NE(test::refusal(with_wheel("", many)).find("weight: 9 are fitted; allowed: at most 8"),
            std::string::npos);
  refuses(demo() + "\n[limits]\nshop_g = -1\n", "shop_g = -1", "shop_g: is -1; allowed");
  refuses(demo() + "\n[limits]\ng = 1\n", "\ng = 1", "g: unknown key");
  refuses(demo() + "\n[[seat]]\nname = \"driver\"\n", "[[seat]]", "position_m: missing");
}

}  // namespace
}  // namespace roadbalance
