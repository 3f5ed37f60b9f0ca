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

#include "common/process/child.hpp"
#include "common/record/file.hpp"
#include "common/record/segment.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"

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
  EXPECT_EQ(result.at("gaps"), 0);
  EXPECT_EQ(result.at("blocks"), result.at("record").at("nodes").at(0).at("blocks"));
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
  EXPECT_TRUE(gap.at("scans_known"));
  EXPECT_LE(gap.at("first_block"), gap.at("last_block"));
  EXPECT_EQ(json(recovered).at("gaps"), 1);
  EXPECT_EQ(rb({"verify", target_}).code, 3);
}

TEST_F(RecoverCommand, WhatIsMadeOfOneOfTwoFoldersSaysSo) {
  std::ofstream(fs::path(record_) / kContinuedInFile) << "/car/second\n";
  ASSERT_EQ(rb({"verify", record_}).code, 3);
  for (const std::string command : {"recover", "select"}) {
    const std::string target = folder_ / command;
    const Outcome made = rb({command, record_, "-o", target});
    EXPECT_EQ(made.code, 3) << command << made.log;
    EXPECT_NE(made.output.find("it goes on in /car/second"), std::string::npos) << made.output;
    const Outcome verified = rb({"verify", target});
    EXPECT_EQ(verified.code, 3) << command;
    EXPECT_NE(verified.output.find("it goes on in /car/second"), std::string::npos) << verified.output;
  }
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

TEST_F(RecoverCommand, NeverWritesIntoWhatItReads) {
  const std::string inside = record_ + "/sub/new", spool = folder_ / "spool";
  const Outcome refused = rb({"recover", record_, "-o", inside});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.log.find(inside + ": lies in " + record_), std::string::npos) << refused.log;
  EXPECT_FALSE(fs::exists(record_ + "/sub"));
  fs::copy(record_, spool);
  fs::create_directory_symlink(spool, folder_ / "link");
  EXPECT_EQ(rb({"recover", record_, "--spool", spool, "-o", folder_ / "link/new"}).code, 1);
  EXPECT_FALSE(fs::exists(spool + "/new"));
  EXPECT_EQ(rb({"recover", record_, "--spool", spool, "-o", record_ + "-beside"}).code, 0);
}

TEST_F(RecoverCommand, RefusesARecordingOrASpoolThatIsBeingRecorded) {
  const std::string spool = folder_ / "spool";
  fs::copy(record_, spool);
  for (const std::string& busy : {record_, spool}) {
    File recorder = File::open_folder(busy);
    ASSERT_TRUE(recorder.try_lock());
    const Outcome refused = rb({"recover", record_, "--spool", spool, "-o", target_});
    EXPECT_EQ(refused.code, 1);
    EXPECT_NE(refused.log.find(busy + ": is being recorded; recover it when that has ended"),
              std::string::npos)
        << refused.log;
    EXPECT_FALSE(fs::exists(target_));
  }
  EXPECT_EQ(rb({"recover", record_, "--spool", record_, "-o", target_}).code, 0)
      << "twice the same is no other";
}

TEST_F(RecoverCommand, SaysWhatAMissingSegmentMayHaveHeld) {
  const auto segment = fs::path(record_) / "seg-000001.lcm";
  fs::resize_file(segment, fs::file_size(segment) - 10'000);
  const Outcome recovered = rb({"recover", record_, "-o", target_, "--json"});
  EXPECT_EQ(recovered.code, 3) << recovered.log;
  EXPECT_EQ(json(recovered).at("missing_segments"), 1);
  EXPECT_NE(json(recovered).at("damage").dump().find("bytes it was finished with"), std::string::npos);
}

TEST_F(RecoverCommand, SaysWhoDoesNotTakeAnArgument) {
  const Outcome without = rb({"recover", record_});
  EXPECT_EQ(without.code, 2);
  EXPECT_NE(without.log.find("rb recover: --output is required"), std::string::npos) << without.log;
  const Outcome long_ago = rb({"watch", "--seconds", "-1"});
  EXPECT_EQ(long_ago.code, 2);
  EXPECT_NE(long_ago.log.find("rb watch: --seconds: '-1' cannot be used; allowed: 0 .. 1000000000 s"),
            std::string::npos)
      << long_ago.log;
}

TEST_F(RecoverCommand, InfoLeavesARecordAloneThatIsBeingWritten) {
  const auto index = fs::path(record_) / "seg-000001.idx";
  fs::remove(index);
  {
    File writer = File::open_folder(record_);
    ASSERT_TRUE(writer.try_lock());
    const Outcome refused = rb({"info", record_, "--rebuild-index"});
    EXPECT_EQ(refused.code, 4);
    EXPECT_NE(refused.log.find("a recorder writes to it"), std::string::npos) << refused.log;
    EXPECT_FALSE(fs::exists(index));
  }
  EXPECT_EQ(rb({"info", record_, "--rebuild-index"}).code, 0);
  EXPECT_TRUE(fs::exists(index));
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
  EXPECT_TRUE(result.at("program").get<std::string>().starts_with("roadbalance "));
  EXPECT_GT(result.at("types").size(), 8u);
  EXPECT_EQ(rb({"info", folder_ / "nothing"}).code, 4);
}

}  // namespace
}  // namespace roadbalance
