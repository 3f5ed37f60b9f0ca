#include "common/multibody/observability.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/multibody/test/reference.hpp"

namespace roadbalance {
namespace {

const std::vector<double> kOmega{100.0, 110.0, 120.0};  // 108 .. 130 km/h on wheels of 0.30 m

std::vector<RotorObservability> seen(const Description& description, const std::vector<int>& sensors = {}) {
  const AffineModel model = affine_model(derive(description));
  return observability(model, model.at(model.nominal), sensors, kOmega);
}

/// The car with an inner and an outer plane at its front left wheel, 7 cm before and 9 cm behind the hub.
Description with_two_planes() {
  std::string text = test::read_source("common/multibody/descriptions/seven_dof.toml");
  text += R"(
[[point]]
name = "inner"
body = "front_left"
position = [0, -0.07, 0]

[[point]]
name = "outer"
body = "front_left"
position = [0, 0.09, 0]

[[unbalance]]
name = "inner"
rotor = "front_left"
point = "inner"
moment = [0, 0]

[[unbalance]]
name = "outer"
rotor = "front_left"
point = "outer"
moment = [0, 0]
)";
  const std::string one =
      "[[unbalance]]\nname = \"front_left\"\nrotor = \"front_left\"\npoint = \"centre_front_left\"\n"
      "moment = [\"cosine_front_left\", \"sine_front_left\"]\n";
  const auto place = text.find(one);
  EXPECT_NE(place, std::string::npos);
  return Description::parse(text.erase(place, one.size()), "two_planes.toml");
}

TEST(Observability, OnePlaneIsToldByAnySensor) {
  for (const auto& rotor : seen(test::description("seven_dof"))) {
    EXPECT_EQ(rotor.observable.cols(), 1) << rotor.rotor;
    EXPECT_EQ(rotor.sentence, "");
  }
  for (const auto& rotor : seen(test::description("seven_dof"), {0}))
    EXPECT_EQ(rotor.sentence, "") << rotor.rotor;
}

TEST(Observability, ACoupleIsNotToldByVerticalMotionAlone) {
  const Description description = with_two_planes();
  // Identical columns of T: the model does not show which plane a force is in.
  const AffineModel model = affine_model(derive(description));
  const auto planes = static_cast<Eigen::Index>(model.plane.size());
  ASSERT_EQ(model.plane[static_cast<std::size_t>(planes - 1)].name, "outer");
  EXPECT_EQ(model.up.col(planes - 1), model.up.col(planes - 2));
  EXPECT_EQ(model.up.col(planes - 1).norm(), 1.0);

  for (const auto& rotor : seen(description)) {
    if (rotor.rotor != "front_left") {
      EXPECT_EQ(rotor.sentence, "");
      continue;
    }
    ASSERT_EQ(rotor.observable.cols(), 1);
    // The sum is observable, the difference is not.
    EXPECT_NEAR(std::abs(rotor.observable.col(0).sum()), std::sqrt(2.0), 1e-9);
    EXPECT_NEAR(std::abs(rotor.unobservable.col(0).sum()), 0.0, 1e-9);
    EXPECT_EQ(rotor.sentence,
              "rotor front_left: of its 2 planes the sensors tell 1 combination; unobservable is 0.71 inner "
              "- 0.71 outer");
  }
}

TEST(Observability, ASecondAxisOfTheHubTellsTheCouple) {
  const Description description = test::description("hub_axis");
  const auto all = seen(description);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].observable.cols(), 2);
  EXPECT_EQ(all[0].sentence, "");
  // Even one sensor on the carrier, since its answers to a force and to a couple change otherwise with speed.
  EXPECT_EQ(seen(description, {2})[0].observable.cols(), 2);
}

TEST(Observability, AStiffHubTellsNoCouple) {
  // Without the axes: toe and camber held, so that only the sum of the planes moves anything.
  std::string text = test::read_source("common/multibody/test/data/hub_axis.toml");
  text = test::replaced(text, "[\"body\", \"wheel\", \"toe\", \"camber\"]", "[\"body\", \"wheel\"]");
  text = test::replaced(text, "axes = \"zx\"\nangles = [\"toe\", \"camber\"]\n", "");
  for (const char* what :
       {"[[spring]]\nname = \"mount\"", "[[spring]]\nname = \"rod\"", "[[damper]]\nname = \"mount\""}) {
    const auto begin = text.find(what);
    ASSERT_NE(begin, std::string::npos);
    text.erase(begin, text.find("[[", begin + 2) - begin);
  }
  const auto all = seen(Description::parse(text, "stiff.toml"));
  EXPECT_EQ(all[0].observable.cols(), 1);
  EXPECT_EQ(
      all[0].sentence,
      "rotor wheel: of its 2 planes the sensors tell 1 combination; unobservable is 0.71 inner - 0.71 outer");
}

TEST(Observability, WithoutSensorsNothingIsTold) {
  Description description = test::description("quarter_car");
  description.sensor.clear();
  EXPECT_EQ(seen(description)[0].sentence,
            "rotor wheel: of its 1 plane the sensors tell 0 combinations; unobservable is 1.00 rim");
}

}  // namespace
}  // namespace roadbalance
