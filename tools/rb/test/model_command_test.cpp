// rb model on what a user has: a vehicle.toml, a description, the name of one that ships.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

class ModelCommand : public testing::Test {
 protected:
  test::Outcome model(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "model");
    return test::run_rb(arguments, folder_ / "rb.log");
  }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  test::TemporaryDirectory folder_;
};

TEST_F(ModelCommand, TellsTheModesOfTheDemoCar) {
  const std::string file = write("vehicle.toml", test::read_source("sim/demo/vehicle.toml"));
  const auto [code, output, log] = model({file, "--json"});
  ASSERT_EQ(code, 0) << log;
  const Json json = Json::parse(output);
  // Computed elsewhere: see the "source" in the file.
  const Json expected = Json::parse(test::read_source("common/vehicle/test/data/car.json"))["modes_hz_zeta"];
  ASSERT_EQ(json["modes"].size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_NEAR(json["modes"][k]["frequency_hz"].get<double>(), expected[k][0].get<double>(), 1e-9);
    EXPECT_NEAR(json["modes"][k]["damping"].get<double>(), expected[k][1].get<double>(), 1e-9);
  }
  EXPECT_EQ(json["sensors"]["names"].size(), 24U);
  EXPECT_EQ(json["parameters"][0]["name"], "body_mass");
  EXPECT_EQ(json["parameters"][0]["matrices"]["M"][0][0], 1.0);
  for (const Json& rotor : json["observability"]) EXPECT_EQ(rotor["sentence"], "");

  const auto modes = model({file, "--modes"});
  EXPECT_EQ(modes.code, 0);
  EXPECT_NE(modes.output.find("  1.234    0.239  heave 1.00"), std::string::npos) << modes.output;
}

TEST_F(ModelCommand, WritesEquationsInEveryForm) {
  const auto summary = model({"quarter_car"});
  EXPECT_EQ(summary.code, 0);
  EXPECT_NE(summary.output.find("Q[wheel, wheel] = spring + tyre\n"), std::string::npos) << summary.output;
  EXPECT_NE(summary.output.find("carrier reads wheel''\n"), std::string::npos) << summary.output;
  EXPECT_NE(model({"half_car", "--latex"}).output.find("\\begin{bmatrix}"), std::string::npos);
  EXPECT_NE(model({"seven_dof", "--cpp"}).output.find("namespace seven_dof {"), std::string::npos);
}

TEST_F(ModelCommand, NamesTheDescriptionsThatShip) {
  const auto [code, output, log] = model({"seven"});
  EXPECT_EQ(code, 4);
  EXPECT_NE(log.find("seven: there is no such file; allowed: a vehicle.toml, a description, quarter_car, "
                     "half_car, seven_dof"),
            std::string::npos)
      << log;
}

TEST_F(ModelCommand, SaysThatACoupleIsNotToldByVerticalSensors) {
  std::string text = test::read_source("common/multibody/descriptions/quarter_car.toml");
  text +=
      "[[point]]\nname = \"inner\"\nbody = \"wheel\"\nposition = [0, -0.1, 0]\n"
      "[[unbalance]]\nname = \"inner\"\nrotor = \"wheel\"\npoint = \"inner\"\nmoment = [0, 0]\n";
  const auto [code, output, log] = model({write("two.toml", text)});
  EXPECT_EQ(code, 0) << log;
  EXPECT_NE(output.find("rotor wheel: of its 2 planes the sensors tell 1 combination; unobservable is 0.71 "
                        "rim - 0.71 inner"),
            std::string::npos)
      << output;
}

TEST_F(ModelCommand, RefusesWithFileAndLine) {
  const auto wrong = model({write("car.toml",
                                  "name = \"x\"\ncoordinates = [\"z\"]\ncolour = 1\n[[body]]\nname = "
                                  "\"b\"\nposition = [0, 0, \"z\"]\n")});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.log.find("car.toml:3: colour: unknown key"), std::string::npos) << wrong.log;
  EXPECT_EQ(model({folder_ / "none.toml"}).code, 4);
  EXPECT_EQ(model({"quarter_car", "--latex", "--cpp"}).code, 2);
}

}  // namespace
}  // namespace roadbalance
