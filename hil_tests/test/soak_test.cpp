#include <gtest/gtest.h>

#include <string>

#include "hil_tests/memory_trend.hpp"
#include "hil_tests/program.hpp"

namespace roadbalance {
namespace {

// The start is the first half: rings and caches fill.  In the other half 30 MB go through the recorder, and
// none of it stays beyond what credit allows.  The long run, to 1 MiB, is a command: see README.
TEST(Soak, TenSecondsAreFlat) {
  const std::string allowed_mib = std::to_string(2 * test::kCredit_mib);
  EXPECT_EQ(test::run("rb-soak", {"--minutes", "0.17", "--settle", "5", "--growth-mib", allowed_mib}, 120),
            0);
}

TEST(Soak, GrowthIsAFailure) {
  EXPECT_EQ(test::run("rb-soak", {"--minutes", "0.03", "--settle", "0.5", "--growth-mib", "-1"}, 120), 1);
}

}  // namespace
}  // namespace roadbalance
