#include "common/angle/mark_scatter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace roadbalance {
namespace {

MarkScatter learned(double sigma_pitches, int marks = 2000) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, sigma_pitches);
  MarkScatter scatter;
  for (int k = 0; k < marks; ++k) scatter.learn(normal(random));
  return scatter;
}

TEST(MarkScatter, LearnsHowFarMarksScatter) {
  // A memory of 100 marks determines the variance to sqrt(2/200) = 10 %; four of these.
  for (const double sigma : {0.02, 0.1}) {
    EXPECT_NEAR(learned(sigma).variance() / (sigma * sigma), 1.0, 0.4) << sigma;
  }
}

TEST(MarkScatter, BeginsWithTheUsualAndDoesNotTakeTheFirstMarkForAll) {
  MarkScatter scatter;
  const double usual = scatter.variance();
  scatter.learn(0.0);
  EXPECT_NEAR(scatter.variance(), usual * 4.0 / 5.0, 1e-12) << "as if four had come before";
}

TEST(MarkScatter, LearnsNoMoreThanHalfAPitchOfAMarkThatHasSlipped) {
  MarkScatter half, wild;
  half.learn(0.5);
  wild.learn(-30.0);
  EXPECT_EQ(half.variance(), wild.variance());
}

TEST(MarkScatter, WeighsASlipAgainstJitterByTheLogarithmOfTheirLikelihoods) {
  const MarkScatter scatter = learned(0.1);
  const double sigma = std::sqrt(scatter.variance());
  const auto log_density = [&](double x) { return -0.5 * x * x / (sigma * sigma); };
  for (const double off : {-1.1, -0.4, 0.0, 0.3, 0.9, 2.2})
    for (const std::int64_t slip : {-2, -1, 0, 1, 2})
      EXPECT_NEAR(scatter.evidence(off, slip),
                  log_density(off - static_cast<double>(slip)) - log_density(off), 1e-9)
          << off << " " << slip;
}

TEST(MarkScatter, HearsNoSingleMarkBeyondDoubtButTwoThatAgree) {
  const MarkScatter scatter = learned(0.1);
  const double one = scatter.evidence_of_one(1.0, 1);
  EXPECT_GT(scatter.evidence(1.0, 1), MarkScatter::kSure);
  EXPECT_GT(one, MarkScatter::kDoubt);
  EXPECT_LT(one, MarkScatter::kSure) << "it could be false";
  EXPECT_GT(2.0 * one, MarkScatter::kSure);
  EXPECT_NEAR(scatter.evidence_of_one(0.0, 1), -one, 1e-12);
}

TEST(MarkScatter, KnowsWhichSlipAMarkSpeaksOf) {
  EXPECT_TRUE(MarkScatter::speaks_of(0.2, 3)) << "against it";
  EXPECT_TRUE(MarkScatter::speaks_of(3.8, 3));
  EXPECT_TRUE(MarkScatter::speaks_of(2.2, 3));
  EXPECT_FALSE(MarkScatter::speaks_of(1.0, 3)) << "of another";
  EXPECT_FALSE(MarkScatter::speaks_of(-3.0, 3));
}

}  // namespace
}  // namespace roadbalance
