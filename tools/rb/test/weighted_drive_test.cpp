#include "tools/rb/weighted_drive.hpp"

#include <gtest/gtest.h>

#include <complex>
#include <functional>
#include <string>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

RotorConfig shaft() {
  return {.name = "shaft",
          .wheel = {2},
          .ratio = 4.0,
          .plane = {{.name = "front", .position_m = {0, 0, 0}, .weight_radius_m = 0.05},
                    {.name = "back", .position_m = {0, 0, 0}, .weight_radius_m = 0.05}}};
}

std::string refusal(const std::function<void()>& what) {
  try {
    what();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(WeightedDrive, IsARecordingAndItsWeights) {
  EXPECT_EQ(WeightedDrive::parse("/rec/bare").folder, "/rec/bare");
  EXPECT_TRUE(WeightedDrive::parse("/rec/a:b").weight.empty()) << "a colon alone is of the name";
  for (const char* folder : {"/rec/speed=80/a", "/rec:run=1/a", "run=1", "/rec/10:20:30"}) {
    EXPECT_EQ(WeightedDrive::parse(folder).folder, folder);
    EXPECT_TRUE(WeightedDrive::parse(folder).weight.empty()) << folder;
  }
  const auto in_it = WeightedDrive::parse("/rec:run=1/a=b:front=20@3");
  EXPECT_EQ(in_it.folder, "/rec:run=1/a=b");
  ASSERT_EQ(in_it.weight.size(), 1U);
  EXPECT_EQ(in_it.weight[0].plane, "front");
  const auto drive = WeightedDrive::parse("/rec:1/a:back=20@90,front=5.5@-180,back=1@90");
  EXPECT_EQ(drive.folder, "/rec:1/a");
  const auto weights = drive.in_planes(shaft());
  ASSERT_EQ(weights.size(), 2U);
  EXPECT_LT(std::abs(weights[0] - std::complex<double>(-5.5, 0.0)), 1e-12);
  EXPECT_LT(std::abs(weights[1] - std::complex<double>(0.0, 21.0)), 1e-12);
}

TEST(WeightedDrive, SaysWhatIsWrong) {
  for (const char* text : {"/rec:front=20", "/rec:front=x@3", "/rec:front=20@", "/rec:=20@3",
                           "/rec:front=-1@3", "/rec:front=20@3@4"})
    EXPECT_NE(refusal([&] { WeightedDrive::parse(text); }).find("PLANE=GRAMS@DEGREES"), std::string::npos)
        << text;
  EXPECT_NE(refusal([&] { WeightedDrive::parse("front=20@3"); }).find("no recording"), std::string::npos);
  EXPECT_NE(refusal([&] {
              (void)WeightedDrive::parse("/rec:side=20@3").in_planes(shaft());
            }).find("side: rotor shaft has no such plane; allowed: front back"),
            std::string::npos);
}

}  // namespace
}  // namespace roadbalance
