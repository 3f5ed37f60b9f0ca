// `rb NAME` where rb has no such command, and what rb prints about itself.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "common/command_line/exit_code.hpp"
#include "common/process/child.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

/// A folder of PATH, and one with a copy of rb and what lies beside it.
class OtherProgram : public testing::Test {
 protected:
  OtherProgram() {
    for (const fs::path& folder : {on_path_, beside_}) fs::create_directory(folder);
    ::setenv("PATH", (on_path_.string() + ":" + before_).c_str(), 1);
  }
  ~OtherProgram() override { ::setenv("PATH", before_.c_str(), 1); }

  static void write_script(const fs::path& file, const std::string& lines) {
    std::ofstream(file) << "#!/bin/sh\n" << lines << "\n";
    fs::permissions(file, fs::perms::owner_all);
  }
  test::Outcome rb(const std::vector<std::string>& words) const { return test::run_rb(words, log_); }

  const test::TemporaryDirectory folder_;
  const fs::path on_path_ = folder_.path() / "path", beside_ = folder_.path() / "beside";
  const fs::path log_ = folder_.path() / "rb.log";
  const std::string before_ = std::getenv("PATH");
};

TEST_F(OtherProgram, GetsTheWordsAsTheyAreAndGivesItsExitCode) {
  write_script(on_path_ / "rb-given", "printf '<%s>' \"$@\"; echo trouble >&2; exit 7");
  const auto outcome = rb({"given", "--help", "--", "two words", "", "--json"});
  EXPECT_EQ(outcome.code, 7);
  EXPECT_EQ(outcome.output, "<--help><--><two words><><--json>");
  EXPECT_EQ(outcome.log, "trouble\n");
  EXPECT_EQ(rb({"help", "given"}).output, "<--help>");
}

TEST_F(OtherProgram, IsInPlaceOfRbForSignals) {
  write_script(on_path_ / "rb-killed", "kill -TERM $$");
  EXPECT_EQ(rb({"killed"}).code, 128 + SIGTERM);
}

TEST_F(OtherProgram, BesideRbGoesBeforeThatOfPath) {
  write_script(on_path_ / "rb-two", "echo on PATH");
  EXPECT_EQ(rb({"two"}).output, "on PATH\n");
  fs::copy_file(fs::path(std::getenv("RB_BIN")) / "rb", beside_ / "rb");
  write_script(beside_ / "rb-two", "echo beside");
  Child copy(beside_ / "rb", {"two"}, log_);
  while (!copy.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(copy.output(), "beside\n") << copy.log();
}

TEST_F(OtherProgram, IsNotAskedForWhatRbDoesItself) {
  write_script(on_path_ / "rb-verify", "exit 7");
  EXPECT_EQ(rb({"verify", "/nowhere"}).code, kCannotAccess);
}

TEST_F(OtherProgram, IsNoFolderAndNoFileThatCannotBeRun) {
  fs::create_directory(on_path_ / "rb-folder");
  std::ofstream(on_path_ / "rb-text") << "text";
  for (const char* const name : {"folder", "text", "../path/rb-text", ""})
    EXPECT_EQ(rb({name}).code, kUsage) << name;
}

TEST_F(OtherProgram, ThatIsListedAndNotThereIsNamed) {
  fs::copy_file(fs::path(std::getenv("RB_BIN")) / "rb", beside_ / "rb");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"study", "list"}, {"identify", "--estimator", "paper", folder_.path()}}) {
    ::setenv("PATH", on_path_.c_str(), 1);
    Child copy(beside_ / "rb", words, log_);
    while (!copy.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_EQ(*copy.ended(), kCannotAccess);
    EXPECT_EQ(copy.log(), "rb: rb-study is not there: neither beside rb nor in a folder of PATH\n");
  }
}

TEST_F(OtherProgram, ThatNobodyHasIsRefusedWithWhatWasMeant) {
  auto outcome = rb({"verfy"});
  EXPECT_EQ(outcome.code, kUsage);
  EXPECT_EQ(outcome.log, "rb: unknown subcommand verfy (did you mean verify?); rb --help lists them\n");
  EXPECT_EQ(rb({"stdy"}).log, "rb: unknown subcommand stdy (did you mean study?); rb --help lists them\n");
  EXPECT_EQ(rb({"help", "verfy"}).log, outcome.log);
  EXPECT_EQ(rb({"frobnicate"}).log, "rb: unknown subcommand frobnicate; rb --help lists them\n");
  outcome = rb({"configure", "filtr", "200"});
  EXPECT_EQ(outcome.code, kUsage);
  EXPECT_EQ(outcome.log,
            "rb: unknown subcommand filtr (did you mean filter?); rb configure --help lists them\n");
}

TEST(Help, IsTheSameHoweverItIsAskedForAndGroupsTheCommands) {
  const test::TemporaryDirectory folder;
  const auto rb = [&](const std::vector<std::string>& words) {
    return test::run_rb(words, folder / "rb.log");
  };
  const auto outcome = rb({"--help"});
  EXPECT_EQ(outcome.code, kDone);
  for (const std::vector<std::string>& words : {std::vector<std::string>{}, {"help"}}) {
    EXPECT_EQ(rb(words).code, kDone);
    EXPECT_EQ(rb(words).output, outcome.output);
  }
  std::size_t at = 0;
  for (const char* const part :
       {"\nSee the car:\n  demo ", "\nRecord:\n  start ", "\nJudge:\n  verify ", "\nLook:\n  info ",
        "\nExchange:\n  import ", "\nSet up:\n  doctor ", "\nDevelop:\n  model ", "\n  study ", "\n  mpi "}) {
    const std::size_t there = outcome.output.find(part, at);
    ASSERT_NE(there, std::string::npos) << part << outcome.output;
    at = there;
  }
  EXPECT_EQ(outcome.output.find("Subcommands:"), std::string::npos) << outcome.output;
  EXPECT_EQ(rb({"help", "configure", "filter"}).output, rb({"configure", "filter", "--help"}).output);
  EXPECT_EQ(rb({"help", "--help"}).code, kDone);
}

TEST(Version, IsThatOfTheProject) {
  const test::TemporaryDirectory folder;
  const auto outcome = test::run_rb({"--version"}, folder / "rb.log");
  EXPECT_EQ(outcome.code, kDone);
  EXPECT_TRUE(outcome.output.starts_with("rb 0.") && outcome.output.ends_with("\n")) << outcome.output;
}

}  // namespace
}  // namespace roadbalance
