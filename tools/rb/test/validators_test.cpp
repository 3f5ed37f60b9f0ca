#include "common/config/validators.hpp"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "tools/rb/command.hpp"
#include "tools/study/study_command.hpp"

namespace roadbalance {
namespace {

TEST(Validators, TakeNumbersWithinAndNothingElse) {
  const auto within = number_within(0.1, 10.0);
  for (const char* good : {"0.1", "10", "1e0", "3.5"}) EXPECT_EQ(within(std::string(good)), "") << good;
  for (const char* bad : {"nan", "-nan", "inf", "0.09", "10.1", "", "1x", "0x1", " 1"})
    EXPECT_EQ(within(std::string(bad)), "'" + std::string(bad) + "' cannot be used; allowed: 0.1 .. 10");
  EXPECT_NE(seconds_or_zero()(std::string("nan")).find("0 .. 1000000000 s"), std::string::npos);
  EXPECT_NE(drive_length()(std::string("nan")), "");
  EXPECT_NE(rate_of_time()(std::string("nan")), "");
}

/// Every option of a number with a fraction, of a command and those below it.
void expect_no_nan(CLI::App& root, CLI::App& command, std::vector<std::string> path, int& asked) {
  command.callback({});  // nothing shall run
  for (CLI::App* below : command.get_subcommands([](const CLI::App*) { return true; })) {
    auto longer = path;
    longer.push_back(below->get_name());
    expect_no_nan(root, *below, longer, asked);
  }
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_type_name().find("FLOAT") == std::string::npos || option->get_name().find("order") == 2)
      continue;
    auto words = path;
    words.push_back(option->get_name());
    words.push_back("nan");
    std::string line = "rb";
    for (const std::string& word : words) line += " " + word;
    ++asked;
    EXPECT_THROW(root.parse(std::vector<std::string>(words.rbegin(), words.rend())), CLI::ValidationError)
        << line;
  }
}

TEST(Validators, KeepNanOutOfEveryCommand) {
  CLI::App app;
  int code = 0, asked = 0;
  add_demo(app, code);
  add_watch(app, code);
  add_datum(app, code);
  add_calibrate(app, code);
  add_wiring(app, code);
  add_doctor(app, code);
  add_distance(app, code);
  add_levels(app, code);
  add_orders(app, code);
  add_spectrum(app, code);
  add_study(*app.add_subcommand("study"), code, run_campaign, 1, true);
  add_supervise(app, code);
  expect_no_nan(app, app, {}, asked);
  EXPECT_GE(asked, 15);
}

}  // namespace
}  // namespace roadbalance
