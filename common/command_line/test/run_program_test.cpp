#include "common/command_line/run_program.hpp"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/command_line/exit_code.hpp"
#include "common/config/section.hpp"

namespace roadbalance {
namespace {

class Program : public testing::Test {
 protected:
  Program() {
    app_.require_subcommand(1);
    app_.add_subcommand("take", "Takes")->callback([this] { code_ = kAnswerIsNo; });
    app_.add_subcommand("refuse", "Refuses")->callback([] { throw ConfigError("no such wheel"); });
    app_.add_subcommand("fail", "Fails")->callback([] { throw std::runtime_error("no such disk"); });
    CLI::App* set = app_.add_subcommand("set", "Sets things");
    set->require_subcommand(1);
    set->add_subcommand("filter", "Sets the filter")->add_option("name");
    list_program(app_, "study", "Studies");
    add_version(app_);
  }

  struct Said {
    int code;
    std::string output, errors;
  };
  Said run(std::vector<std::string> words) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int code = run_program(app_, std::move(words), code_);
    Said said{code, testing::internal::GetCapturedStdout(), testing::internal::GetCapturedStderr()};
    return said;
  }

  CLI::App app_{"Does what cars need.", "car"};
  int code_ = kDone;
};

TEST_F(Program, EndsWithTheCodeOfItsCommand) {
  EXPECT_EQ(run({"set", "filter"}).code, kDone);
  EXPECT_EQ(run({"take"}).code, kAnswerIsNo);
}

TEST_F(Program, SaysInALineWhatWentWrong) {
  auto said = run({"refuse"});
  EXPECT_EQ(said.code, kUsage);
  EXPECT_EQ(said.errors, "car: no such wheel\n");
  said = run({"fail"});
  EXPECT_EQ(said.code, kCannotAccess);
  EXPECT_EQ(said.errors, "car: no such disk\n");
  said = run({"take", "--much"});
  EXPECT_EQ(said.code, kUsage);
  EXPECT_TRUE(said.errors.starts_with("car take: ") && said.errors.ends_with("; car take --help says more\n"))
      << said.errors;
}

// A name, a key or a path in it is foreign.
TEST_F(Program, SaysItInOneLineWithoutHiddenCharacters) {
  EXPECT_EQ(run({"take", "--\x1b[2J\n"}).errors.find_first_of("\x1b"), std::string::npos);
  testing::internal::CaptureStderr();
  EXPECT_EQ(report_failure(app_, ConfigError("car.toml:1: a\x1b[2J\nb: unknown key")), kUsage);
  EXPECT_EQ(report_failure(app_, std::runtime_error("/media/\u202Ea: no such disk")), kCannotAccess);
  report("rb-node", "drive\ncomplete");
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "car: car.toml:1: a\\x1B[2J\\x0Ab: unknown key\ncar: /media/\\u202Ea: no such disk\n"
            "rb-node: drive\\x0Acomplete\n");
}

TEST_F(Program, NamesTheCommandThatWasMeant) {
  EXPECT_EQ(run({"takes"}).errors,
            "car: unknown subcommand takes (did you mean take?); car --help lists them\n");
  EXPECT_EQ(run({"set", "fitler"}).errors,
            "car: unknown subcommand fitler (did you mean filter?); car set --help lists them\n");
  EXPECT_EQ(run({"stduy"}).errors,
            "car: unknown subcommand stduy (did you mean study?); car --help lists them\n");
  const auto said = run({"xyzzy"});
  EXPECT_EQ(said.code, kUsage);
  EXPECT_EQ(said.errors, "car: unknown subcommand xyzzy; car --help lists them\n");
}

TEST_F(Program, SaysItsVersionWithItsName) {
  const auto said = run({"--version"});
  EXPECT_EQ(said.code, kDone);
  EXPECT_TRUE(said.output.starts_with("car 0.") && said.output.ends_with("\n")) << said.output;
}

}  // namespace
}  // namespace roadbalance
