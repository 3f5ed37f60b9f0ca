// `rb twin` on a short recorded drive of the simulated car.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/test/run_rb.hpp"
#include "tools/rb/test/simulated_drives.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

class TwinCommand : public testing::Test {
 protected:
  void record(int seconds, const std::string& first_channel = "fl_carrier_z") {
    std::string text = test::replaced(test::slow_car(), "\ncutoff_hz = 60", "\ncutoff_hz = 100");
    text = test::replaced(text, "\"fl_carrier_z\"", "\"" + first_channel + "\"");
    test::record_scenario(drive_, VehicleConfig::parse(text, "vehicle.toml"),
                          "?seed=4&seconds=" + std::to_string(seconds));
  }
  test::Outcome twin(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "twin");
    return test::run_rb(arguments, folder_ / "log");
  }

  test::TemporaryDirectory folder_;
  const std::filesystem::path drive_ = folder_ / "drive";
};

TEST_F(TwinCommand, TellsEachChannelThatTheModelSpeaksOfAndNamesTheOthers) {
  record(20);
  const std::string csv = folder_ / "twin.csv";
  const test::Outcome outcome =
      twin({drive_, "--nominal", "--from", "10", "--to", "15", "--csv", csv, "--json"});
  ASSERT_EQ(outcome.code, kDone) << outcome.log;
  const Json json = Json::parse(outcome.output);
  EXPECT_FALSE(json["identified"]);
  ASSERT_EQ(json["channels"].size(), 8U);  // four carriers and four struts, vertical
  for (const Json& channel : json["channels"]) {
    EXPECT_EQ(channel["seconds"], 5);
    const Json& all = channel["all"];
    const double measured = all["measured_m_s2"], residual = all["residual_m_s2"];
    EXPECT_NEAR(all["explained"].get<double>(), 1.0 - residual * residual / (measured * measured), 1e-9);
  }
  EXPECT_EQ(json["not_modelled"].size(), 16U);

  std::ifstream file(csv);
  std::string names, units, line;
  std::getline(file, names);
  std::getline(file, units);
  EXPECT_TRUE(names.starts_with("time_s,fl_carrier_z_measured,fl_carrier_z_predicted,")) << names;
  double measured = 0.0, residual = 0.0;
  int rows = 0;
  for (; std::getline(file, line); ++rows) {
    std::istringstream cells(line);
    std::string time, of_sensor, of_twin;
    std::getline(cells, time, ',');
    std::getline(cells, of_sensor, ',');
    std::getline(cells, of_twin, ',');
    measured += std::stod(of_sensor) * std::stod(of_sensor);
    residual += std::pow(std::stod(of_sensor) - std::stod(of_twin), 2);
  }
  EXPECT_EQ(rows, 2500);
  EXPECT_NEAR(1.0 - residual / measured, json["channels"][0]["all"]["explained"].get<double>(), 1e-4);
}

// A spreadsheet computes a cell that begins with "="; RFC 4180 has quotes around one with a comma.
TEST_F(TwinCommand, NoNameOfAChannelIsComputedByASpreadsheet) {
  record(20, "=cmd,x");
  ASSERT_EQ(twin({drive_, "--nominal", "--from", "10", "--to", "12", "--csv", folder_ / "twin.csv"}).code,
            kDone);
  std::ifstream file(folder_ / "twin.csv");
  std::string names;
  std::getline(file, names);
  EXPECT_TRUE(names.starts_with("time_s,\"'=cmd,x_measured\",\"'=cmd,x_predicted\",")) << names;
}

TEST_F(TwinCommand, OfADriveTooShortToSettleThereIsNoAccount) {
  record(3);
  const test::Outcome outcome = twin({drive_, "--nominal"});
  EXPECT_EQ(outcome.code, kAnswerIsNo);
  EXPECT_NE(outcome.output.find("not predicted: too short to settle"), std::string::npos) << outcome.output;
}

TEST_F(TwinCommand, RefusesWhatCannotBe) {
  EXPECT_EQ(twin({folder_ / "none"}).code, kCannotAccess);
  record(3);
  EXPECT_EQ(twin({drive_, "--from", "5", "--to", "4"}).code, kUsage);
  std::ofstream(folder_ / "there.csv") << "mine";
  const test::Outcome outcome = twin({drive_, "--nominal", "--csv", folder_ / "there.csv"});
  EXPECT_EQ(outcome.code, kCannotAccess);
  EXPECT_NE(outcome.log.find("there.csv: exists already"), std::string::npos) << outcome.log;
}

}  // namespace
}  // namespace roadbalance
