// The study's results for runs whose numbers are known beforehand.
#include "tools/study/many_drives.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>

#include "tools/study/study.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

Json summary_of(const std::vector<Json>& runs) {
  const Study& study = study_of("many-drives");
  return study.summarise(study.settings, runs).summary;
}

double value_of(const Json& summary, const std::string& begin) {
  for (const Json& line : summary["acceptance"])
    if (line["line"].get<std::string>().starts_with(begin)) return line["value"].get<double>();
  throw std::out_of_range("no acceptance line " + begin);
}

/// Runs in which the estimate of so many drives is off by `off(drives)`, in g and in % of the tyres.
/// @param plain    times as much in plain sums
/// @param ellipse  of 95 of a hundred runs
std::vector<Json> runs_off_by(const std::function<double(int)>& off, double plain, double ellipse) {
  std::vector<Json> runs;
  for (int i = 0; i < 100; ++i) {
    Json car = Json::object();
    for (const Joined joined : kJoined)
      for (const int size : joined_sizes(16)) {
        const double error = off(size) * (joined == Joined::kPlainSums ? plain : 1.0);
        car[joined_key(joined, size)] = Json(4, {{"off_g", {error, -error}},
                                                 {"ellipse", i < 95 ? ellipse : 9.0},
                                                 {"sigma_g", error},
                                                 {"tyre_percent", error},
                                                 {"tyre_sigmas", i < 95 ? -1.9 : 2.1},
                                                 {"ratio", 1.0}});
      }
    runs.push_back({{"seed", i}, {"alike", car}, {"differ", car}});
  }
  return runs;
}

double root(int drives) {
  return 4.0 / std::sqrt(drives);
}

TEST(ManyDrives, AreAskedToGetBetterAsTheRootOfTheirNumber) {
  const Json good = summary_of(runs_off_by(root, 1.5, 5.9));
  EXPECT_TRUE(good["accepted"].get<bool>()) << good;
  EXPECT_NEAR(value_of(good, "alike: unbalances: error of 4"), 2.0, 1e-9);
  EXPECT_NEAR(value_of(good, "differ: tyres: error of plain"), 1.5, 1e-9);
  EXPECT_NEAR(value_of(good, "differ, 8 drives: unbalances"), 95.0, 1e-9);
  const auto no_better = [](int) { return 1.0; };
  EXPECT_FALSE(summary_of(runs_off_by(no_better, 1.5, 5.9))["accepted"].get<bool>());
}

TEST(ManyDrives, AreNotAcceptedIfPlainSumsAreBetterOrEllipsesTooSmall) {
  EXPECT_FALSE(summary_of(runs_off_by(root, 0.9, 5.9))["accepted"].get<bool>());
  EXPECT_FALSE(summary_of(runs_off_by(root, 1.5, 6.1))["accepted"].get<bool>());
}

TEST(ManyDrives, ThatTellNothingHoldNoTruth) {
  auto runs = runs_off_by(root, 1.5, 5.9);
  for (Json& run : runs)
    for (Json& wheel : run["alike"][joined_key(Joined::kProduct, 4)]) wheel["ellipse"] = nullptr;
  const Json summary = summary_of(runs);
  EXPECT_EQ(value_of(summary, "alike, 4 drives: unbalances"), 0.0);
  EXPECT_FALSE(summary["accepted"].get<bool>());
}

}  // namespace
}  // namespace roadbalance
