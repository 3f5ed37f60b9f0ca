#include "common/process/pause.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace roadbalance {
namespace {

using std::chrono::steady_clock;

TEST(Pause, IsOverNoSoonerThanItsTime) {
  const std::stop_source nobody;
  const auto begun = steady_clock::now();
  EXPECT_TRUE(pause(nobody.get_token(), std::chrono::milliseconds(5)));
  EXPECT_GE(steady_clock::now() - begun, std::chrono::milliseconds(5));
}

// From ten years it would not come back otherwise.
TEST(Pause, EndsAtOnceWhenToldToStop) {
  const auto ten_years = std::chrono::hours(87'600);
  bool went_on = true;
  std::jthread pausing([&](const std::stop_token& stop) { went_on = pause(stop, ten_years); });
  pausing.request_stop();
  pausing.join();
  EXPECT_FALSE(went_on);

  std::stop_source before;
  before.request_stop();
  EXPECT_FALSE(pause(before.get_token(), ten_years));
}

}  // namespace
}  // namespace roadbalance
