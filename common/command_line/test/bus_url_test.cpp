#include "common/command_line/bus_url.hpp"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cstdlib>

namespace roadbalance {
namespace {

constexpr const char* kOfTheCar = "udpm://239.255.76.67:7667?ttl=1";

class BusUrl : public ::testing::Test {
 protected:
  BusUrl() { ::setenv("LCM_DEFAULT_URL", kOfTheCar, 1); }
  ~BusUrl() override { ::unsetenv("LCM_DEFAULT_URL"); }

  std::string parsed(const std::string& line) {
    CLI::App app;
    std::string url;
    add_bus_url(app, url);
    app.parse(line);
    return url;
  }
};

TEST_F(BusUrl, IsThatOfTheEnvironmentUnlessOneIsGiven) {
  EXPECT_EQ(parsed(""), kOfTheCar);
  EXPECT_EQ(parsed("--url udpm://239.255.76.67:7668"), "udpm://239.255.76.67:7668");
}

TEST_F(BusUrl, ItsHelpSaysTheSameOnEveryComputer) {
  CLI::App app;
  std::string url;
  add_bus_url(app, url);
  EXPECT_EQ(app.get_option("--url")->get_default_str(),
            "$LCM_DEFAULT_URL, or udpm://239.255.76.67:7667?ttl=0");
}

}  // namespace
}  // namespace roadbalance
