// The recording commands and folders that hold no recording, several, or somebody else's.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/record/file.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class FolderCommands : public testing::Test {
 protected:
  test::Outcome rb(const std::vector<std::string>& arguments) {
    return test::run_rb(arguments, folder_ / "rb.log");
  }
  test::Outcome import(const std::string& into) {
    return rb({"import", "csv", "--samples", test::source_path("tools/rb/test/data/wobbletracker.csv"),
               "--vehicle", test::source_path("tools/rb/test/data/wobbletracker.toml"), "-o", into});
  }

  const test::TemporaryDirectory folder_;
};

TEST_F(FolderCommands, ListWhatIsInAFolderWithoutNamingIt) {
  const fs::path all = folder_.path() / "all";
  fs::create_directory(all);
  for (const char* name : {"first", "second", "damaged"}) ASSERT_EQ(import(all / name).code, 0);
  fs::resize_file(all / "damaged" / "seg-000001.lcm", fs::file_size(all / "damaged" / "seg-000001.lcm") / 2);
  fs::create_directory(all / "pictures");
  int age_min = 10;
  for (const char* name : {"first", "second", "damaged"})
    fs::last_write_time(all / name / "seg-000001.lcm",
                        fs::file_time_type::clock::now() - std::chrono::minutes(age_min--));
  const test::Outcome told = rb({"info", all, "--json"});
  ASSERT_EQ(told.code, 0) << told.log;
  const Json listed = Json::parse(told.output)["recordings"];
  ASSERT_EQ(listed.size(), 3U) << told.output;
  EXPECT_EQ(listed[0]["name"], "damaged") << "newest first";
  EXPECT_EQ(listed[0]["state"], "damaged");
  EXPECT_EQ(listed[1]["name"], "second");
  EXPECT_EQ(listed[1]["state"], "complete");
  EXPECT_EQ(listed[2]["nodes"][0]["samples_lost"], 0);
  EXPECT_NEAR(listed[2]["seconds"].get<double>(), 10.0, 1.0);
  EXPECT_NE(rb({"info", all}).output.find("second"), std::string::npos);
  // One that grows is not read, nor are the others beside it: the disk is the recorder's.
  fs::last_write_time(all / "first" / "seg-000001.lcm", fs::file_time_type::clock::now());
  File recorder = File::open_folder(all / "first");
  ASSERT_TRUE(recorder.try_lock());
  const Json busy = Json::parse(rb({"info", all, "--json"}).output)["recordings"];
  EXPECT_EQ(busy[0]["state"], "being recorded");
  EXPECT_EQ(busy[1]["state"], "not read");
  EXPECT_EQ(rb({"info", all / "pictures"}).code, 4);
}

/// As LCM's logger writes them: sync word, number, microseconds, lengths, big-endian.
void write_foreign_log(const fs::path& file, int events) {
  std::ofstream log(file, std::ios::binary);
  const auto put = [&](std::uint64_t value, int bytes) {
    for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) log.put(static_cast<char>(value >> shift));
  };
  for (int k = 0; k < events; ++k) {
    put(0xEDA1DA01, 4);
    put(static_cast<std::uint64_t>(k), 8);
    put(1'000'000 + 1'000 * static_cast<std::uint64_t>(k), 8);
    put(7, 4);
    put(100, 4);
    log << "EXAMPLE" << std::string(100, 'x');
  }
}

TEST_F(FolderCommands, SayWhatAFolderHoldsThatIsNoneOfOurs) {
  const std::string segment = "/seg-000001.lcm";
  for (const char* name : {"empty", "text", "other"}) fs::create_directory(folder_.path() / name);
  std::ofstream(folder_ / "empty" + segment);
  std::ofstream(folder_ / "text" + segment) << "this is no log at all, and never was one";
  write_foreign_log(folder_ / "other" + segment, 50);
  for (const auto& [name, words] :
       {std::pair{"empty", "nothing was written into its segments"},
        {"text", "seg-000001.lcm: no event of an LCM log from byte 0 on"},
        {"other", "50 events, but none of ours (channel EXAMPLE from byte 0 of seg-000001.lcm)"}})
    for (const char* command : {"verify", "info", "identify", "levels", "orders"}) {
      const test::Outcome refused = rb({command, folder_ / name});
      EXPECT_EQ(refused.code, 4) << command << refused.log;
      EXPECT_NE(refused.log.find(words), std::string::npos) << command << ": " << refused.log;
    }
}

TEST_F(FolderCommands, GiveATerminalNoCommandsOutOfNames) {
  const test::Outcome absent = rb({"verify", folder_ / "\x1b[2Jnone"});
  EXPECT_EQ(absent.code, 4);
  EXPECT_EQ(absent.log.find('\x1b'), std::string::npos);
  EXPECT_NE(absent.log.find("\\x1B[2Jnone"), std::string::npos) << absent.log;
}

}  // namespace
}  // namespace roadbalance
