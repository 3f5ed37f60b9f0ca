#include "firmware/backends/replay/lateness.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;

TEST(Lateness, TellsMeanShareAndMost) {
  Lateness lateness;
  for (int k = 1; k <= 1000; ++k) lateness.add(microseconds(k));  // 1 .. 1000 us, evenly
  EXPECT_EQ(lateness.events(), 1000);
  EXPECT_NEAR(lateness.mean_ms(), 0.5005, 1e-9);
  EXPECT_NEAR(lateness.most_ms(), 1.0, 1e-9);
  for (const double share : {0.01, 0.1, 0.5, 0.9}) {  // the true one is that of the share, up to a bin more
    EXPECT_GE(lateness.within_ms(share), share - 1e-9) << share;
    EXPECT_LE(lateness.within_ms(share), share * 1.0906) << share;
  }
  EXPECT_EQ(lateness.within_ms(1.0), lateness.most_ms());
}

TEST(Lateness, WhatIsEarlyIsInTime) {
  Lateness lateness;
  lateness.add(nanoseconds(-5'000'000));
  EXPECT_EQ(lateness.mean_ms(), 0.0);
  EXPECT_EQ(lateness.most_ms(), 0.0);
  EXPECT_EQ(lateness.within_ms(0.99), 0.0);
}

TEST(Lateness, WhatIsLaterThanAllBinsIsStillTold) {
  Lateness lateness;
  lateness.add(std::chrono::hours(1));
  EXPECT_NEAR(lateness.most_ms(), 3.6e6, 1e-3);
}

TEST(Lateness, SaysSoInASentence) {
  Lateness lateness;
  for (int k = 0; k < 4; ++k) lateness.add(microseconds(3000));
  EXPECT_EQ(lateness.sentence(),
            "4 runs of scans: 3.00 ms late in the mean, 3.00 ms in 99 %, 3.00 ms at most");
}

}  // namespace
}  // namespace roadbalance
