// `rb identify` of many recordings of one car.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/test/temporary_directory.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/test/run_rb.hpp"
#include "tools/rb/test/simulated_drives.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;
constexpr int kDrives = 8;

std::string name_of(int drive) {
  return "drive-" + std::to_string(10 + drive);
}

class IdentifyMany : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    drives_ = new test::TemporaryDirectory;
    for (int i = 0; i < kDrives; ++i)
      test::record_drive({.seed = static_cast<std::uint64_t>(i + 1),
                          .speed_km_h = 105.0 + 3.0 * i,
                          .road_class = i % 3 == 2 ? "B" : "A"},
                         drives_->path() / name_of(i), test::slow_car());
  }
  static void TearDownTestSuite() { delete drives_; }

  static std::string drive(int i) { return drives_->path() / name_of(i); }

  test::Outcome identify(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "identify");
    return test::run_rb(arguments, folder_.path() / "rb.log");
  }
  /// A copy beside which others can lie.
  std::string copy(int i, const std::string& name) {
    const fs::path to = folder_.path() / name;
    fs::copy(drive(i), to, fs::copy_options::recursive);
    return to;
  }
  std::string other_car(const std::string& from, const std::string& to) {
    const fs::path folder = folder_.path() / "zz-other";
    test::record_drive({.seed = 99}, folder, test::replaced(test::slow_car(), from, to));
    return folder;
  }

  static inline test::TemporaryDirectory* drives_ = nullptr;
  const test::TemporaryDirectory folder_;
};

/// Squared distance from the truth in units of the told covariance.
double off(const Json& wheel, std::size_t w) {
  const auto told = std::polar(wheel["unbalance_g"].get<double>(),
                               wheel["angle_deg"].get<double>() * std::numbers::pi / 180.0);
  const auto truth =
      std::polar(test::kDrivenUnbalance_g[w], test::kDrivenAngle_deg[w] * std::numbers::pi / 180.0);
  const auto d = told - truth;
  const Json& c = wheel["covariance_g2"];
  const double a = c[0][0], b = c[0][1], e = c[1][1];
  return (e * d.real() * d.real() - 2.0 * b * d.real() * d.imag() + a * d.imag() * d.imag()) /
         (a * e - b * b);
}

TEST_F(IdentifyMany, TellsTheCarBetterThanOneDriveWithTheTruthInItsEllipses) {
  const test::Outcome all = identify({drives_->path(), "--json"});
  ASSERT_EQ(all.code, kDone) << all.log;
  const Json together = Json::parse(all.output);
  ASSERT_EQ(together["recordings"].size(), std::size_t{kDrives});
  EXPECT_EQ(together["recordings"][0]["name"], name_of(0));
  EXPECT_TRUE(together["left_out"].empty());
  const test::Outcome two = identify({drive(0), drive(1), "--json"});
  ASSERT_EQ(two.code, kDone) << two.log;
  const Json pair = Json::parse(two.output);
  double sum = 0.0;
  for (std::size_t w = 0; w < kWheels; ++w) {
    // A chi^2 of two degrees of freedom is larger once in 5000.
    EXPECT_LT(off(together["wheels"][w], w), 17.0) << w;
    sum += together["wheels"][w]["covariance_g2"][0][0].get<double>() /
           pair["wheels"][w]["covariance_g2"][0][0].get<double>();
  }
  // A quarter by the number of drives, roads of class B apart; what gains of sensors leave does not fall.
  EXPECT_LT(sum / kWheels, 0.7);
}

TEST_F(IdentifyMany, SaysTheSameBitForBitHoweverManyWorkAndInWhateverOrder) {
  const test::Outcome one = identify({drives_->path(), "--json", "--jobs", "1"});
  ASSERT_EQ(one.code, kDone) << one.log;
  for (const char* jobs : {"2", "8"})
    EXPECT_EQ(identify({drives_->path(), "--json", "--jobs", jobs}).output, one.output) << jobs;
  std::vector<std::string> backwards;
  for (int i = kDrives; i-- > 0;) backwards.push_back(drive(i));
  backwards.emplace_back("--json");
  EXPECT_EQ(identify(backwards).output, one.output);
  std::swap(backwards[1], backwards[5]);
  EXPECT_EQ(identify(backwards).output, one.output);
}

TEST_F(IdentifyMany, RefusesWhatDoesNotBelongTogetherNamingKeyAndBoth) {
  const std::vector<std::tuple<std::string, std::string, std::string>> cases{
      {"datum_deg = 30\n",
       "datum_deg = 30\n[[wheel.weight]]\nmass_g = 20\nangle_deg = 210\nradius_m = 0.19\n",
       "wheel front_left: weight: none there, 20 g at 210 deg on 0.19 m here"},
      {"datum_deg = 30\n", "datum_deg = 31\n", "wheel front_left: datum_deg: 30 there, 31 here"},
      {"body_mass_kg = 1300", "body_mass_kg = 1301", "model.body_mass_kg: 1300 there, 1301 here"}};
  for (const auto& [from, to, sentence] : cases) {
    const std::string other = other_car(from, to);
    const test::Outcome mixed = identify({other, drive(0), drive(1), "--json"});
    EXPECT_EQ(mixed.code, kUsage) << mixed.log;
    EXPECT_TRUE(mixed.output.empty());
    EXPECT_NE(mixed.log.find(drive(0) + " and " + other + " do not belong together: " + sentence),
              std::string::npos)
        << mixed.log;
    fs::remove_all(other);
  }
}

TEST_F(IdentifyMany, CountsNoDriveTwice) {
  const test::Outcome twice = identify({drive(0), drive(1), drive(0)});
  EXPECT_EQ(twice.code, kUsage);
  EXPECT_NE(twice.log.find(drive(0) + " is named twice"), std::string::npos) << twice.log;
  const std::string again = copy(1, "copied");
  const test::Outcome copied = identify({drive(0), drive(1), again});
  EXPECT_EQ(copied.code, kUsage);
  EXPECT_NE(copied.log.find(again + " and " + drive(1) + " hold the same samples of node"), std::string::npos)
      << copied.log;
}

// Subsets tell what they are made of: parts of one drive may stand beside each other, but not beside the
// whole.
TEST_F(IdentifyMany, CountsNoPartOfADriveTwice) {
  const std::string most = folder_.path() / "z-most", begin = folder_.path() / "y-begin",
                    rest = folder_.path() / "x-rest", again = folder_.path() / "w-again";
  ASSERT_EQ(test::run_rb({"select", drive(1), "--from", "5", "-o", most}, folder_.path() / "rb.log").code,
            kDone);
  ASSERT_EQ(test::run_rb({"select", drive(1), "--to", "30", "-o", begin}, folder_.path() / "rb.log").code,
            kDone);
  ASSERT_EQ(test::run_rb({"select", drive(1), "--from", "30", "-o", rest}, folder_.path() / "rb.log").code,
            kDone);
  ASSERT_EQ(test::run_rb({"select", begin, "--to", "25", "-o", again}, folder_.path() / "rb.log").code,
            kDone);
  for (const auto& [one, other] :
       {std::pair{drive(1), most}, {drive(1), begin}, {drive(1), again}, {begin, again}}) {
    const test::Outcome both = identify({drive(0), one, other});
    EXPECT_EQ(both.code, kUsage) << one << " " << other << both.log;
    EXPECT_NE(both.log.find("hold the same samples of node"), std::string::npos) << both.log;
  }
  const test::Outcome parts = identify({drive(0), begin, rest, "--json"});
  ASSERT_EQ(parts.code, kDone) << parts.log;
  EXPECT_EQ(Json::parse(parts.output)["recordings"].size(), 3U);
}

TEST_F(IdentifyMany, LeavesOutWhatIsUnusableOnlyWhenAsked) {
  const test::Outcome good = identify({drive(0), drive(1), drive(2), "--json"});
  const std::string damaged = copy(3, "a-damaged"), brief = folder_.path() / "b-short";
  {
    std::fstream file(damaged + "/seg-000001.lcm", std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(fs::file_size(damaged + "/seg-000001.lcm") / 2));
    file.write("\0\0\0\0\0\0\0\0", 8);
  }
  test::record_drive({.seed = 77, .seconds = 6.0}, brief, test::slow_car());
  const fs::path empty = folder_.path() / "c-empty";
  fs::create_directory(empty);
  for (const auto& [bad, why] : {std::pair{damaged, "damaged: "}, {brief, "too short: "}}) {
    const test::Outcome refused = identify({drive(0), drive(1), drive(2), bad, "--json"});
    EXPECT_EQ(refused.code, kAnswerIsNo) << refused.log;
    EXPECT_TRUE(refused.output.empty());
    EXPECT_NE(refused.log.find(bad + ": " + why), std::string::npos) << refused.log;
  }
  const test::Outcome rest =
      identify({drive(0), drive(1), drive(2), damaged, brief, empty, "--json", "--skip-unusable"});
  ASSERT_EQ(rest.code, kDone) << rest.log;
  Json told = Json::parse(rest.output);
  ASSERT_EQ(told["left_out"].size(), 3U) << told["left_out"];
  EXPECT_NE(rest.log.find("left out " + damaged), std::string::npos) << rest.log;
  told["left_out"] = Json::array();
  EXPECT_EQ(told, Json::parse(good.output)) << "what is left out does not count";
  EXPECT_EQ(identify({damaged, brief, "--skip-unusable"}).code, kAnswerIsNo);
}

/// Weights that somebody clipped on and did not write down.
TEST_F(IdentifyMany, RemarksOnDrivesThatDifferByMoreThanChance) {
  const std::string changed = folder_.path() / "changed";
  const std::string car = test::slow_car();
  test::record_drive({.seed = 50}, changed, car, test::OtherMass{0, 25.0});
  const test::Outcome outcome = identify({drives_->path(), changed, "--json"});
  ASSERT_EQ(outcome.code, kDone) << outcome.log;
  const auto remarks = Json::parse(outcome.output)["remarks"];
  EXPECT_TRUE(std::ranges::any_of(remarks, [](const Json& remark) {
    return remark.get<std::string>().starts_with("front_left: its unbalance differs between the drives");
  })) << remarks;
  const auto alike = Json::parse(identify({drives_->path(), "--json"}).output)["remarks"];
  for (const Json& remark : alike)
    EXPECT_EQ(remark.get<std::string>().find("differs between"), std::string::npos);
}

TEST_F(IdentifyMany, TellsAHundredShortDrivesWithOneDamaged) {
  const fs::path many = folder_.path() / "hundred";
  fs::create_directory(many);
  for (int i = 0; i < 100; ++i)
    test::record_drive(
        {.seed = static_cast<std::uint64_t>(200 + i), .speed_km_h = 100.0 + i % 7, .seconds = 14.0},
        many / ("short-" + std::to_string(100 + i)), test::slow_car());
  const fs::path segment = many / "short-142" / "seg-000001.lcm";
  fs::resize_file(segment, fs::file_size(segment) / 3);
  {
    std::fstream file(segment, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(fs::file_size(segment) / 2));
    file.write("\0\0\0\0\0\0\0\0", 8);
  }
  const test::Outcome outcome = identify({many, "--json", "--skip-unusable"});
  ASSERT_EQ(outcome.code, kDone) << outcome.log;
  const Json told = Json::parse(outcome.output);
  ASSERT_EQ(told["left_out"].size(), 1U);
  EXPECT_EQ(told["left_out"][0]["name"], "short-142");
  EXPECT_EQ(told["recordings"].size(), 99U);
  for (std::size_t w = 0; w < kWheels; ++w) EXPECT_LT(off(told["wheels"][w], w), 17.0) << w;
  EXPECT_EQ(identify({many, "--json", "--skip-unusable", "--jobs", "3"}).output, outcome.output);
}

}  // namespace
}  // namespace roadbalance
