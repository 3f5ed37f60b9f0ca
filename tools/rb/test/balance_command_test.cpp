// rb balance --readings: what somebody wrote down of any instrument.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/test/temporary_directory.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

class BalanceReadings : public testing::Test {
 protected:
  test::Outcome balance(const std::string& table, const std::vector<std::string>& more = {}) {
    std::ofstream(folder_ / "table.csv") << table;
    std::vector<std::string> arguments{"balance", "--readings", folder_ / "table.csv"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test::run_rb(arguments, folder_ / "rb.log");
  }
  const test::TemporaryDirectory folder_;
};

// T. Feese and P. Grazier, Balance This!, 33rd Turbomachinery Symposium (2004): the first trial weight stays
// on. They print 15.3 at 3 and 6.6 at 113 degrees; least squares by another program: 15.330 at 2.9, 6.617 at
// 112.9, condition number of their influence coefficients 3.1436.
TEST_F(BalanceReadings, SolvesAPublishedCaseWhoseTrialWeightStaysOn) {
  const test::Outcome done = balance(
      "run,weight left,weight right,1x,1y,2x,2y\n"
      ",oz,oz,mil,mil,mil,mil\n"
      "bare,,,.68@32,.56@86,1.94@231,2.07@335\n"
      "first,11.1@35,0,1.31@1,1.25@75,.93@251,1@342\n"
      "both,11.1@35,3.7@135,.54@9,.52@75,.81@196,.9@296\n",
      {"--json"});
  ASSERT_EQ(done.code, 0) << done.log;
  const Json json = Json::parse(done.output);
  EXPECT_NEAR(json["planes"][0]["mass"].get<double>(), 15.330, 0.001);
  EXPECT_NEAR(json["planes"][0]["angle_deg"].get<double>(), 2.9, 0.05);
  EXPECT_NEAR(json["planes"][1]["mass"].get<double>(), 6.617, 0.001);
  EXPECT_NEAR(json["planes"][1]["angle_deg"].get<double>(), 112.9, 0.05);
  EXPECT_NEAR(json["condition"].get<double>(), 3.1436, 0.0001);
  EXPECT_EQ(json["weight_unit"], "oz");
  EXPECT_EQ(json["reading_unit"], "mil");
  EXPECT_NE(done.log.find("what the digits of the readings leave open"), std::string::npos);
}

// One plane: w = -t b / (s - b), here -60 mg * 100 / (-150) = 40 mg at 0.
TEST_F(BalanceReadings, PrintsAsManyDigitsAsTheUncertaintyAllows) {
  const auto table = [](const char* sigma) {
    return std::string(
               "run,turns,weight hub,front,sigma front\n,1/s,g,counts,counts\n"
               "bare,49,,100@0,") +
           sigma + "\ntrial,49.2,0.060@0,50@180," + sigma + "\n";
  };
  // sigma of each part: 0.060 / 150^2 * hypot(50, 100) s = 2.98e-4 g for s = 1; along and across alike.
  const test::Outcome fine = balance(table("1"));
  ASSERT_EQ(fine.code, 0) << fine.log;
  EXPECT_NE(fine.output.find("hub: 0.04000 ± 0.00030 g at 0.00 ± 0.43 deg"), std::string::npos)
      << fine.output;
  EXPECT_NE(fine.output.find("2 runs at 49.1 1/s, 0 beyond those needed"), std::string::npos) << fine.output;
  const test::Outcome coarse = balance(table("30"));
  EXPECT_NE(coarse.output.find("hub: 0.0400 ± 0.0089 g at 0 ± 13 deg"), std::string::npos) << coarse.output;
}

TEST_F(BalanceReadings, NamesRunsOfAnotherSpeed) {
  const std::string table =
      "run,speed,weight "
      "hub,front\n,rpm,g,mm/s\nbare,3000,,10.0@0\ntrial,3010,2@0,5.0@0\nfast,3500,2@0,7.0@90\n";
  const test::Outcome done = balance(table, {"--json"});
  ASSERT_EQ(done.code, 0) << done.log;
  const Json json = Json::parse(done.output);
  EXPECT_EQ(json["runs"], (Json{"bare", "trial"}));
  ASSERT_EQ(json["other_speed"].size(), 1U);
  EXPECT_EQ(json["other_speed"][0]["run"], "fast");
  EXPECT_NE(done.log.find("run fast at 3500 rpm is left out"), std::string::npos) << done.log;
  const test::Outcome alone = balance(table, {"--speed", "3500"});
  EXPECT_EQ(alone.code, 1);
  EXPECT_NE(alone.log.find("run bare at 3000 rpm is left out"), std::string::npos) << alone.log;
  EXPECT_NE(alone.log.find("at the same speed"), std::string::npos) << alone.log;
}

TEST_F(BalanceReadings, RefusesWhatIsWrongByLineAndColumn) {
  const std::string head = "run,speed,weight hub,front,sigma front\n", units = ",1/s,g,mm/s,mm/s\n";
  const std::map<std::string, std::string> cases{
      {"", "header: the file is empty"},
      {"name,front\n", "name: is the first column; allowed: run"},
      {"run,weight hub\n,g\n", "no column is a reading"},
      {"run,front\n,mm/s\n", "no column is a weight"},
      {"run,weight hub,front,front\n", "front: stands twice"},
      {"run,speed,turns,weight hub,front\n", "two columns are the speed"},
      {"run,weight hub,front,sigma rear\n", "sigma rear: there is no such channel"},
      {head, "units: missing"},
      {"run,weight hub,front\nbare,,3.4@116\n", "front: \"3.4@116\" is no unit"},
      {"run,weight hub,a,b\n,g,mm/s,mil\n", "b: is in \"mil\", but a in \"mm/s\""},
      {head + units, "run: there is none"},
      {head + units + "bare,49,,3.4@116\n", "row: 4 cells; allowed: 5"},
      {head + units + "bare,49,,3.4,\n", "front: \"3.4\" of run bare; allowed: AMPLITUDE@DEGREES"},
      {head + units + "bare,49,,-3.4@116,\n", "front: \"-3.4@116\" of run bare"},
      {head + units + "bare,49,2,3.4@116,\n", "weight hub: \"2\" of run bare; allowed: AMOUNT@DEGREES"},
      {head + units + "bare,,,3.4@116,\n", "speed: \"\" of run bare; allowed: a number above 0"},
      {head + units + "bare,49,,3.4@116,0\n", "sigma front: \"0\" of run bare; allowed: a number above 0"},
      {head + units + "bare,49,,3.4@116,\nbare,49,1@0,3@0,\n", "run: bare stands twice"}};
  for (const auto& [table, words] : cases) {
    const test::Outcome done = balance(table);
    EXPECT_EQ(done.code, 2) << table;
    EXPECT_NE(done.log.find("table.csv"), std::string::npos) << done.log;
    EXPECT_NE(done.log.find(words), std::string::npos) << words << "\n" << done.log;
  }
  EXPECT_EQ(balance(head, {"--rotor", "shaft"}).code, 2) << "drives and readings exclude each other";
  EXPECT_EQ(test::run_rb({"balance"}, folder_ / "rb.log").code, 2);
}

}  // namespace
}  // namespace roadbalance
