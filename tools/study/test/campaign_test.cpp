#include "tools/study/campaign.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

class CampaignTest : public testing::Test {
 protected:
  CampaignTest() {
    std::string name = (std::filesystem::temp_directory_path() / "campaign-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    campaign_ = {"squares", {{"offset", 1}}, 5, 10, folder_ / "state", 2};
  }
  ~CampaignTest() override { std::filesystem::remove_all(folder_); }

  /// An experiment that leaves a mark for each time it was run; runs are processes of their own.
  Experiment marked() const {
    return [log = (folder_ / "log").string()](std::uint64_t seed) {
      std::ofstream(log, std::ios::app) << seed << '\n';
      return Json{{"square", seed * seed}, {"process", getpid()}};
    };
  }
  int times_run() const {
    std::ifstream log(folder_ / "log");
    int lines = 0;
    for (std::string line; std::getline(log, line);) ++lines;
    return lines;
  }

  std::filesystem::path folder_;
  Campaign campaign_;
};

TEST_F(CampaignTest, ReturnsEveryRunInOrderOfSeed) {
  const auto results = run_campaign(campaign_, marked());
  ASSERT_EQ(results.size(), 5U);
  for (std::uint64_t i = 0; i < 5; ++i) EXPECT_EQ(results[i]["square"], (10 + i) * (10 + i));
  EXPECT_NE(results[0]["process"], getpid());
}

TEST_F(CampaignTest, GoesOnWhereItStopped) {
  campaign_.runs = 2;
  run_campaign(campaign_, marked());
  campaign_.runs = 5;
  EXPECT_EQ(run_campaign(campaign_, marked()).size(), 5U);
  EXPECT_EQ(times_run(), 5);
}

TEST_F(CampaignTest, DoesRunsAnewThatWereMadeWithOtherSettings) {
  run_campaign(campaign_, marked());
  campaign_.settings["offset"] = 2;
  run_campaign(campaign_, marked());
  EXPECT_EQ(times_run(), 10);
}

TEST_F(CampaignTest, DoesARunAnewWhoseResultWasCutShort) {
  run_campaign(campaign_, marked());
  std::filesystem::resize_file(campaign_.state / "squares-12.json", 20);
  EXPECT_EQ(run_campaign(campaign_, marked())[2]["square"], 144);
  EXPECT_EQ(times_run(), 6);
}

TEST_F(CampaignTest, NamesTheSeedThatFailedAndKeepsTheOthers) {
  campaign_.jobs = 1;
  const auto fails_at_12 = [&](std::uint64_t seed) {
    if (seed == 12) throw std::runtime_error("no road");
    return marked()(seed);
  };
  try {
    run_campaign(campaign_, fails_at_12);
    FAIL() << "a failed run must not pass";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("12"), std::string::npos) << error.what();
  }
  run_campaign(campaign_, marked());
  EXPECT_EQ(times_run(), 5);
}

}  // namespace
}  // namespace roadbalance
