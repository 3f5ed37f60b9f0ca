#include <gtest/gtest.h>

#include <string>

#include "hil_tests/program.hpp"

namespace roadbalance {
namespace {

// The start is the first half.  In the other half 30 MB go through the recorder, and none of it stays,
// however busy the disk and slow the machine is.  The long run is a command: see README.
TEST(Soak, TenSecondsAreFlat) {
  EXPECT_EQ(test::run("rb-soak",
                      {"--minutes", "0.17", "--settle", "5", "--growth-mb", "1", "--least-share", "0"}, 120),
            0);
}

TEST(Soak, GrowthIsAFailure) {
  EXPECT_EQ(
      test::run("rb-soak",
                {"--minutes", "0.03", "--settle", "0.5", "--growth-mb", "-1", "--least-share", "0"}, 120),
      1);
}

TEST(Soak, AMachineThatIsTooSlowIsAFailure) {
  EXPECT_EQ(test::run("rb-soak",
                      {"--minutes", "0.03", "--settle", "0.5", "--growth-mb", "1e6", "--rate", "1000"}, 120),
            1);
}

}  // namespace
}  // namespace roadbalance
