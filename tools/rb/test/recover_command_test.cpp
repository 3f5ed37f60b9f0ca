// rb recover and rb info on an imported measurement that is damaged on purpose.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/rb/child.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

struct Outcome {
  int code;
  std::string output, log;
};

class RecoverCommand : public testing::Test {
 protected:
  RecoverCommand() {
    EXPECT_EQ(rb({"import", "csv", "--samples", test::source_path("tools/rb/test/data/wobbletracker.csv"),
                  "--vehicle", test::source_path("tools/rb/test/data/wobbletracker.toml"), "-o", record_})
                  .code,
              0);
  }
  Outcome rb(const std::vector<std::string>& arguments) {
    Child child(fs::path(std::getenv("RB_BIN")) / "rb", arguments, folder_ / "rb.log");
    while (!child.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return {*child.ended(), child.output(), child.log()};
  }
  Json json(const Outcome& outcome) { return Json::parse(outcome.output, nullptr, false); }
  void damage() {
    std::fstream segment(fs::path(record_) / "seg-000001.lcm",
                         std::ios::binary | std::ios::in | std::ios::out);
    segment.seekp(static_cast<std::streamoff>(fs::file_size(fs::path(record_) / "seg-000001.lcm") / 2));
    segment << std::string(3000, 'x');
  }

  const test::TemporaryDirectory folder_;
  const std::string record_ = folder_ / "record", target_ = folder_ / "recovered";
};

TEST_F(RecoverCommand, OfAGoodRecordingLosesNothing) {
  const Outcome recovered = rb({"recover", record_, "-o", target_, "--json"});
  ASSERT_EQ(recovered.code, 0) << recovered.log;
  const Json result = json(recovered);
  EXPECT_EQ(result.at("damaged_bytes"), 0);
  EXPECT_TRUE(result.at("record").at("complete"));
  EXPECT_EQ(rb({"verify", target_}).code, 0);
}

TEST_F(RecoverCommand, OfADamagedOneListsEachHoleAndItsRecordIsGood) {
  damage();
  ASSERT_EQ(rb({"verify", record_}).code, 1);
  const Outcome recovered = rb({"recover", record_, "-o", target_, "--json"});
  ASSERT_EQ(recovered.code, 3) << recovered.log;
  const Json node = json(recovered).at("record").at("nodes").at(0);
  ASSERT_EQ(node.at("gaps").size(), 1u);
  const Json gap = node.at("gaps").at(0);
  EXPECT_EQ(gap.at("cause"), "lost_in_record");
  EXPECT_EQ(node.at("samples_recorded").get<int>() + gap.at("scans").get<int>(), node.at("samples_sent"));
  EXPECT_GT(gap.at("milliseconds"), 0.0);
  EXPECT_EQ(rb({"verify", target_}).code, 3);
}

TEST_F(RecoverCommand, RefusesWhatItCannotDo) {
  fs::create_directories(target_);
  std::ofstream(fs::path(target_) / "mine") << "keep";
  const Outcome refused = rb({"recover", record_, "-o", target_});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.log.find(target_), std::string::npos) << refused.log;
  EXPECT_TRUE(fs::exists(fs::path(target_) / "mine"));
  EXPECT_EQ(rb({"recover", folder_ / "nothing", "-o", folder_ / "new"}).code, 1);
  EXPECT_FALSE(fs::exists(folder_ / "new"));
}

TEST_F(RecoverCommand, InfoSaysWhatIsThereAndMakesIndexesAgain) {
  const auto index = fs::path(record_) / "seg-000001.idx";
  ASSERT_TRUE(fs::remove(index));
  const Outcome said = rb({"info", record_, "--rebuild-index", "--json"});
  ASSERT_EQ(said.code, 0) << said.log;
  EXPECT_TRUE(fs::exists(index));
  const Json result = json(said);
  EXPECT_EQ(result.at("segments").size(), 1u);
  EXPECT_GT(result.at("rates").at(0).at("rate_hz"), 0.0);
  EXPECT_NE(result.at("vehicle"), "not described");
  EXPECT_EQ(rb({"info", folder_ / "nothing"}).code, 4);
}

}  // namespace
}  // namespace roadbalance
