// `rb identify` on what to do: weights of a car whose vehicle.toml says which there are, where they go and
// which are fitted.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <tuple>

#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "sim/truth.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/test/run_rb.hpp"
#include "tools/rb/test/simulated_drives.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;
constexpr double kDegree = std::numbers::pi / 180.0;

/// The demo car at 500 scans a second with weights in steps of 10 g, one for each wheel and place of a raster
/// of 15 degrees, clipped or, on another radius of the front left wheel, stuck; 20 g are stuck there opposite
/// to the heavy spot.
VehicleConfig car() {
  std::string text = test::slow_car();
  text = test::replaced(text, "datum_deg = 30\n",
                        "datum_deg = 30\n[[wheel.weight]]\nmass_g = 20\nangle_deg = 210\nradius_m = 0.16\n");
  const std::string inner = "radius_m = 0.19\nkind = \"clip\"\nplane = \"inner\"\n";
  text.replace(text.find(inner), inner.size(), "radius_m = 0.16\nkind = \"adhesive\"\nplane = \"inner\"\n");
  text +=
      "\n[weights]\nstep_g = 10\nmost = 1\nraster_deg = 15\n[limits]\nshop_g = 2\n"
      "[[seat]]\nname = \"driver\"\nposition_m = [0.1, 0.35, 0.2]\n";
  return VehicleConfig::parse(text, "vehicle.toml");
}

/// The unbalance that the steps add, g at 0.19 m.
std::complex<double> added_g(const Json& steps) {
  std::complex<double> sum = 0.0;
  for (const Json& step : steps) {
    const auto moment = std::polar(step["mass_g"].get<double>() * step["radius_m"].get<double>() / 0.19,
                                   step["angle_deg"].get<double>() * kDegree);
    if (step["action"] == "add" || step["action"] == "move") sum += moment;
    if (step["action"] == "remove") sum -= moment;
    if (step["action"] == "move")
      sum -= std::polar(step["mass_g"].get<double>() * step["from_radius_m"].get<double>() / 0.19,
                        step["from_deg"].get<double>() * kDegree);
  }
  return sum;
}

/// Within four of their standard deviations of the car that was driven, and those no wider than 5 %.
void expect_suspension(const Json& told) {
  const ParameterVector truth = sim::truth_of("", 4, car()).car.parameters;
  for (const auto& [name, first, count] : {std::tuple{"spring_n_m", +kSpring, +kWheels},
                                           {"damper_n_s_m", +kDamper, +kWheels},
                                           {"stabiliser_n_m", +kStabiliser, +kAxles}}) {
    ASSERT_EQ(told[name].size(), static_cast<std::size_t>(count)) << name;
    for (int i = 0; i < count; ++i) {
      const Json& one = told[name][static_cast<std::size_t>(i)];
      EXPECT_NEAR(one["value"].get<double>(), truth(first + i), 4.0 * one["sigma"].get<double>()) << name;
      EXPECT_LT(one["sigma"].get<double>(), 0.05 * truth(first + i)) << name;
    }
  }
}

class IdentifyWeights : public testing::Test {
 protected:
  void drive(int seconds) {
    test::record_scenario(record_, car(), "?seed=4&seconds=" + std::to_string(seconds));
  }
  test::Outcome identify(const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"identify", record_, "--overall"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test::run_rb(arguments, folder_ / "rb.log");
  }

  const test::TemporaryDirectory folder_;
  const std::string record_ = folder_.path() / "record";
};

TEST_F(IdentifyWeights, TellsStepsOfTheStockThatLeaveWhatItSays) {
  drive(200);
  const test::Outcome outcome = identify({"--json"});
  ASSERT_EQ(outcome.code, kDone) << outcome.log;
  const Json told = Json::parse(outcome.output);
  for (std::size_t w = 0; w < kWheels; ++w) {
    const Json &wheel = told["wheels"][w], &compensation = told["compensation"][w];
    ASSERT_EQ(compensation["advice"], "steps") << w;
    EXPECT_EQ(compensation["of"], "correction");
    EXPECT_EQ(compensation["shop_g"], 2.0);
    const auto touched = std::ranges::count_if(compensation["steps"],
                                               [](const Json& step) { return step["action"] != "keep"; });
    EXPECT_LE(touched, 2);
    for (const Json& step : compensation["steps"])
      if (step["action"] == "add") {
        EXPECT_EQ(std::fmod(step["mass_g"].get<double>(), 10.0), 0.0);
        EXPECT_NEAR(std::remainder(step["angle_deg"].get<double>(), 15.0), 0.0, 1e-9);
      }
    // Half a step, and half a place of the raster.
    const auto left =
        std::polar(wheel["unbalance_g"].get<double>(), wheel["angle_deg"].get<double>() * kDegree) +
        added_g(compensation["steps"]);
    EXPECT_LT(std::abs(left), std::hypot(5.0, 35.0 * std::sin(7.5 * kDegree)) + 1.0) << w;
    // The unbalance that it reports as left includes what is not known.
    EXPECT_GT(compensation["residual_g"].get<double>(), std::abs(left));
    EXPECT_LT(compensation["residual_g"].get<double>(), std::abs(left) + 3.0);
    EXPECT_EQ(compensation["within_shop"], compensation["residual_g"].get<double>() <= 2.0);
  }
  expect_suspension(told["suspension"]);
  EXPECT_FALSE(told["speeds"].empty());
  EXPECT_LT(told["wheels"][0]["force_n"].get<double>(),
            3.5 * told["wheels"][0]["sigma_force_n"].get<double>())
      << "there is none";
  const auto& front_left = told["compensation"][0]["steps"];
  EXPECT_TRUE(std::ranges::any_of(front_left, [](const Json& step) { return step["action"] != "add"; }))
      << "the fitted weight is spoken of";

  const Json& overall = told["overall"];
  EXPECT_EQ(overall["seats"].at(0)["name"], "driver");
  EXPECT_FALSE(overall["speeds"].empty());
  const auto all = [&](const char* key) { return overall["all"][key].get<double>(); };
  EXPECT_LE(all("least_m_s2"), all("overall_m_s2"));
  EXPECT_LT(all("overall_m_s2"), all("now_m_s2"));

  const test::Outcome read = identify({});
  EXPECT_NE(read.output.find(" in the inner plane (160 mm)"), std::string::npos) << read.output;
  EXPECT_NE(read.output.find("\n  springs "), std::string::npos) << read.output;
  EXPECT_NE(read.output.find("what a shop leaves (2 g)"), std::string::npos);
  EXPECT_NE(read.output.find("least vertical vibration at driver"), std::string::npos);
}

TEST_F(IdentifyWeights, SaysNothingOfWeightsWhileNothingIsKnown) {
  drive(20);
  const test::Outcome outcome = identify({"--json"});
  EXPECT_EQ(outcome.code, kAnswerIsNo);
  const Json told = Json::parse(outcome.output);
  EXPECT_TRUE(told["compensation"][0]["advice"].is_null());
  EXPECT_TRUE(told["compensation"][0]["steps"].is_null());
  EXPECT_TRUE(told["overall"].is_null());
  EXPECT_NE(outcome.log.find("no overall compensation: what turns with the wheels is not known"),
            std::string::npos)
      << outcome.log;
}

}  // namespace
}  // namespace roadbalance
