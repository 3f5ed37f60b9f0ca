#include "tools/study/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace roadbalance {
namespace {

TEST(Quantile, LiesBetweenTheNeighbours) {
  EXPECT_DOUBLE_EQ(quantile({3.0, 1.0, 2.0}, 0.5), 2.0);
  EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 2.0, 3.0}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile({0.0, 10.0}, 0.95), 9.5);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(Sizes, CountWhatIsUnknownAsTheWorst) {
  const ErrorSizes sizes = sizes_of({-1.0, std::nan(""), 2.0});
  EXPECT_DOUBLE_EQ(sizes.median, 2.0);
  EXPECT_TRUE(std::isinf(sizes.p95));
  EXPECT_TRUE(std::isnan(sizes.deviation));
}

TEST(StandardDeviation, IsAboutTheMean) {
  EXPECT_DOUBLE_EQ(standard_deviation({4.0, 6.0, 8.0}), 2.0);
  EXPECT_TRUE(std::isnan(standard_deviation({1.0})));
}

TEST(Acceptance, OfNoNumberIsNotMet) {
  const auto line = acceptance_line("x", std::nan(""), 0.0, 1.0);
  EXPECT_FALSE(line["met"].get<bool>());
  EXPECT_TRUE(line["value"].is_null());
  EXPECT_TRUE(acceptance_line("x", 1.0, 0.0, 1.0)["met"].get<bool>());
  EXPECT_FALSE(all_met({acceptance_line("x", 1.0, 0.0, 1.0), line}));
}

TEST(Acceptance, OfNothingIsNotMet) {
  EXPECT_FALSE(all_met(nlohmann::ordered_json::array()));
  EXPECT_FALSE(acceptance_line("x", 0.0, 0.0, 1.0, answers_among({std::nan("")}))["met"].get<bool>());
  const auto line = acceptance_line("x", 0.0, 0.0, 1.0, answers_among({std::nan(""), 0.0, 3.0}));
  EXPECT_TRUE(line["met"].get<bool>());
  EXPECT_EQ(line["answers"], 2);
}

// One side of four sigma is 3.2e-5.  In 20 throws of a coin none and 1 are rarer (21 / 2^20 = 2.0e-5), 2 are
// not (211 / 2^20 = 2.0e-4).
TEST(ShareLimits, AreThoseOfTheBinomialDistribution) {
  EXPECT_NEAR(share_limits(0.5, 20).least, 10.0, 1e-9);
  EXPECT_NEAR(share_limits(0.5, 20).most, 90.0, 1e-9);
  EXPECT_EQ(share_limits(0.5, 0).most, 100.0);
  // Many: as the normal distribution has it, to one answer and its skewness.
  const ShareLimits many = share_limits(0.8, 1'000'000);
  EXPECT_NEAR(many.least, 80.0 - 400.0 * std::sqrt(0.8 * 0.2 / 1e6), 2e-3);
  EXPECT_NEAR(many.most, 80.0 + 400.0 * std::sqrt(0.8 * 0.2 / 1e6), 2e-3);
}

TEST(ShareLine, IsNotJudgedByTooFewAnswersToFail) {
  // 0.86^70 = 2.6e-5 is rarer than 3.2e-5, 0.86^68 is not; of five all may be wrong: 0.14^5 = 5.4e-5.
  EXPECT_TRUE(share_line("x", 100.0, 0.86, 5)["met"].is_null());
  EXPECT_TRUE(share_line("x", 100.0, 0.86, 68)["met"].get<bool>());
  EXPECT_FALSE(share_line("x", 100.0, 0.86, 70)["met"].get<bool>());
  EXPECT_FALSE(share_line("x", 0.0, 0.86, 6)["met"].get<bool>());
  EXPECT_FALSE(share_line("x", 0.0, 0.86, 0)["met"].get<bool>());
  const auto met = acceptance_line("y", 1.0, 0.0, 2.0), missed = acceptance_line("y", 3.0, 0.0, 2.0);
  const auto open = share_line("x", 100.0, 0.86, 5);
  EXPECT_FALSE(all_met(nlohmann::ordered_json::array({open})));
  EXPECT_TRUE(all_met(nlohmann::ordered_json::array({open, met})));
  EXPECT_FALSE(all_met(nlohmann::ordered_json::array({open, met, missed})));
}

}  // namespace
}  // namespace roadbalance
