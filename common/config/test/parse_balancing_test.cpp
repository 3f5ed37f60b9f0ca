#include "common/config/parse_balancing.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <regex>

#include "common/config/test/refusal.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// The demonstration car, whose file does not name the places of weights.
std::string demo() {
  static const std::regex places(
      R"((# Where weights go[^\n]*\n)?\[\[wheel\.place\]\]\n([a-z_]+ = [^\n]+\n)+)");
  return std::regex_replace(test::read_source("sim/demo/vehicle.toml"), places, "");
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

std::string place(const std::string& radius_m, const std::string& kind = "clip",
                  const std::string& plane = "outer") {
  return "[[wheel.place]]\nradius_m = " + radius_m + "\nkind = \"" + kind + "\"\nplane = \"" + plane + "\"\n";
}
std::string weight(const std::string& where) {
  return "[[wheel.weight]]\nmass_g = 5\nangle_deg = -90\n" + where;
}

constexpr WeightPlace kOuterClip{0.19, WeightKind::kClip, RimPlane::kOuter};
constexpr WeightPlace kInnerClip{0.19, WeightKind::kClip, RimPlane::kInner};
constexpr WeightPlace kStuck{0.16, WeightKind::kAdhesive, RimPlane::kInner};

TEST(Balancing, NeedsNoWordsForStepsOfFiveGramsAnywhereAtTheWeightRadius) {
  const VehicleConfig vehicle = car(demo());
  for (const WheelConfig& wheel : vehicle.wheel) {
    EXPECT_EQ(wheel.stock.step_g, 5.0);
    EXPECT_EQ(wheel.stock.most, 2);
    EXPECT_EQ(wheel.stock.raster_rad, 0.0);
    EXPECT_EQ(wheel.stock.place, std::vector{WeightPlace{.radius_m = wheel.weight_radius_m}});
    EXPECT_TRUE(wheel.fitted.empty());
  }
  EXPECT_EQ(vehicle.limits.shop_g, 7.0);
  EXPECT_EQ(vehicle.limits.grade_mm_s, 40.0);
  EXPECT_TRUE(vehicle.seat.empty());
}

TEST(Balancing, TakesWhatWeightsAndPlacesThereAre) {
  const VehicleConfig vehicle = car(
      with_wheel("", place("0.19") + place("0.16", "adhesive", "inner") +
                         "[[wheel.weight]]\nmass_g = 20\nangle_deg = 45\n" + weight("radius_m = 0.16\n")) +
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
  EXPECT_EQ(wheel.stock.place, (std::vector{kOuterClip, kStuck}));
  EXPECT_EQ(vehicle.wheel[1].stock.place, std::vector{WeightPlace{.radius_m = 0.19}});
  EXPECT_EQ(vehicle.wheel[1].stock.step_g, 7.5);
  ASSERT_EQ(wheel.fitted.size(), 2U);
  EXPECT_EQ(wheel.fitted[0].mass_g, 20.0);
  EXPECT_EQ(wheel.fitted[0].place, kOuterClip);
  EXPECT_NEAR(wheel.fitted[1].angle_rad, -90.0 * kDegree, 1e-15);
  EXPECT_EQ(wheel.fitted[1].place, kStuck);
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

// Values missing for a weight are those of the first place that has all else; a weight may sit on none of
// them.
TEST(Balancing, FindsThePlaceOfAFittedWeight) {
  const auto where = [](const std::string& told) {
    return car(with_wheel("", place("0.19") + place("0.19", "clip", "inner") +
                                  place("0.16", "adhesive", "inner") + weight(told)))
        .wheel[0]
        .fitted.at(0)
        .place;
  };
  EXPECT_EQ(where(""), kOuterClip);
  EXPECT_EQ(where("radius_m = 0.19\n"), kOuterClip);
  EXPECT_EQ(where("plane = \"inner\"\n"), kInnerClip);
  EXPECT_EQ(where("kind = \"adhesive\"\n"), kStuck);
  EXPECT_EQ(where("radius_m = 0.16\nplane = \"inner\"\n"), kStuck);
  EXPECT_EQ(where("radius_m = 0.17\nkind = \"clip\"\nplane = \"inner\"\n"),
            (WeightPlace{0.17, WeightKind::kClip, RimPlane::kInner}));
}

TEST(Balancing, NamesWhatAPlaceLacks) {
  const auto refuses = [](const std::string& table, const std::string& at, const std::string& says) {
    test::expect_refusal(with_wheel("", table), 0, at, says);
  };
  refuses("[[wheel.place]]\nkind = \"clip\"\nplane = \"outer\"\n", "[[wheel.place]]", "radius_m: missing");
  refuses("[[wheel.place]]\nradius_m = 0.19\nplane = \"outer\"\n", "[[wheel.place]]", "kind: missing");
  refuses("[[wheel.place]]\nradius_m = 0.19\nkind = \"clip\"\n", "[[wheel.place]]", "plane: missing");
  refuses(place("0.19", "glue"), "kind = \"glue\"", "kind: is 'glue'; allowed: clip, adhesive");
  refuses(place("0.19", "clip", "left"), "plane = \"left\"", "plane: is 'left'; allowed: inner, outer");
  refuses(place("0.3"), "[[wheel.place]]\nradius_m = 0.3", "radius_m: must be less than rolling_radius_m");
  refuses(place("0.19") + place("0.18") +
              "[[wheel.place]]\nkind = \"clip\"\nplane = \"outer\"\nradius_m = 0.190\n",
          "radius_m = 0.190", "radius_m: this place stands twice");
  refuses(weight("radius_m = 0.16\n"), "[[wheel.weight]]", "kind: missing; allowed: to leave it out where");
  refuses(place("0.19") + weight("plane = \"inner\"\n"), "[[wheel.weight]]",
          "radius_m: missing; allowed: to leave it out where");
  refuses(place("0.19") + weight("plane = \"inner\"\nradius_m = 0.19\n"), "[[wheel.weight]]",
          "kind: missing; allowed: to leave it out where");
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
  refuses(with_wheel("weight_radii_m = [0.19, 0.16]\n"), "weight_radii_m",
          "weight_radii_m: unknown key; allowed: a [[wheel.place]] with radius_m, kind and plane");
  const std::string places = place("0.1") + place("0.12") + place("0.14");
  refuses(with_wheel("", places + place("0.16") + place("0.18")), "[[wheel.place]]",
          "place: 5 are told; allowed: at most 4");
  const std::string three = with_wheel("", places) + "\n[weights]\nstep_g = 1\n";
  refuses(three + "heaviest_g = 67\n", "[[wheel.place]]",
          "place: with 67 masses on each place; allowed: at most 200 choices");
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
