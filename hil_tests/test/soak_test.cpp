#include <gtest/gtest.h>

#include "hil_tests/program.hpp"

namespace roadbalance {
namespace {

// The start is the first half: rings and caches fill.  The long run is a command, see README.
TEST(Soak, TenSecondsAreFlat) {
  EXPECT_EQ(test::run("rb-soak", {"--minutes", "0.17", "--settle", "5"}, 120), 0);
}

TEST(Soak, GrowthIsAFailure) {
  EXPECT_EQ(test::run("rb-soak", {"--minutes", "0.03", "--settle", "0.5", "--growth-mib", "-1"}, 120), 1);
}

}  // namespace
}  // namespace roadbalance
