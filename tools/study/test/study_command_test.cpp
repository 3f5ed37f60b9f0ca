#include "tools/study/study_command.hpp"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

TEST(StudyCommand, RefusesOptionsOfAnotherStudy) {
  for (const std::vector<std::string>& words : {std::vector<std::string>{"encoder", "--jobs", "3"},
                                                {"clock-skew", "--drive-seconds", "100"},
                                                {"demo-accuracy", "--nodes", "3"},
                                                {"encoder", "--svg", "figures"}}) {
    CLI::App app;
    int code = 0;
    add_study(app, code, run_campaign, 1, true);
    try {
      app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
      ADD_FAILURE() << words[0] << " ran";
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(words[1] + ": is not of study " + words[0]),
                std::string::npos);
      // All that take it.
      const std::string said = error.what(), allowed = said.substr(said.find("allowed with "));
      const bool svg = words[1] == "--svg";
      EXPECT_EQ(allowed.find(", drift") != std::string::npos, svg || words[1] == "--jobs") << said;
      EXPECT_EQ(allowed.find("parameters") != std::string::npos, svg) << said;
    }
  }
}

TEST(StudyCommand, NeedsANameUnlessAnotherCommandIsCalled) {
  CLI::App app;
  int code = 0, called = 0;
  add_study(app, code, run_campaign, 1, true);
  app.add_subcommand("identify")->callback([&called] { ++called; });
  EXPECT_THROW(app.parse("--json"), CLI::RequiredError);
  EXPECT_THROW(app.parse("fig4711"), ConfigError);
  app.parse("identify");
  EXPECT_EQ(called, 1);
}

}  // namespace
}  // namespace roadbalance
