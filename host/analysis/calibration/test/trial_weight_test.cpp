#include "host/analysis/calibration/trial_weight.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "host/analysis/identify/extra_variance.hpp"

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Eigen::Vector2d polar(double length, double angle_rad) {
  return length * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
}

/// Result of a drive for an unbalance at `angle_rad` from the reference point, if the datum used is not the
/// true one.
FoundUnbalance found(const Eigen::Vector2d& unbalance_g, double true_datum_rad, double datum_rad,
                     const Eigen::Matrix2d& covariance) {
  const double angle = std::atan2(unbalance_g.y(), unbalance_g.x());
  return {polar(unbalance_g.norm(), angle + true_datum_rad - datum_rad), covariance, datum_rad};
}

const Eigen::Matrix2d kExact = 1e-6 * Eigen::Matrix2d::Identity();

TEST(DatumByTrialWeight, IsTheTrueDatumWhateverTheDrivesWereAnalysedWith) {
  const Eigen::Vector2d own = polar(18.0, 2.0), weight = polar(30.0, 90.0 * kDegree);
  for (const auto& [first, second] : {std::pair{30.0, 30.0}, {20.0, 20.0}, {20.0, 75.0}, {-170.0, 160.0}}) {
    const auto datum = datum_by_trial_weight(found(own, 30.0 * kDegree, first * kDegree, kExact),
                                             found(own + weight, 30.0 * kDegree, second * kDegree, kExact),
                                             {30.0, 90.0 * kDegree, 2.0 * kDegree});
    ASSERT_TRUE(datum);
    EXPECT_NEAR(datum->datum_rad, 30.0 * kDegree, 1e-9) << first << " " << second;
    EXPECT_NEAR(datum->change_g, 30.0, 1e-9);
    EXPECT_NEAR(datum->sigma_rad, 2.0 * kDegree, 1e-6) << "as well as the weight was placed";
  }
}

TEST(DatumByTrialWeight, SaysHowFarItIsOff) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Eigen::Matrix2d root_before, root_after;
  root_before << 0.5, 0.0, 0.3, 0.4;
  root_after << 0.6, -0.2, 0.0, 0.9;
  const TrialWeight weight{30.0, 90.0 * kDegree, 1.0 * kDegree};
  double square = 0.0, mass_square = 0.0;
  constexpr int kRuns = 4000;
  for (int run = 0; run < kRuns; ++run) {
    const auto noise = [&] { return Eigen::Vector2d(normal(random), normal(random)); };
    const Eigen::Vector2d own = polar(18.0, 2.0) + root_before * noise();
    const Eigen::Vector2d with = polar(18.0, 2.0) +
                                 polar(30.0, weight.angle_rad + weight.angle_sigma_rad * normal(random)) +
                                 root_after * noise();
    const auto datum =
        datum_by_trial_weight(found(own, 0.0, 0.0, root_before * root_before.transpose()),
                              found(with, 0.0, 0.0, root_after * root_after.transpose()), weight);
    ASSERT_TRUE(datum);
    square += std::pow(datum->datum_rad / datum->sigma_rad, 2);
    mass_square += std::pow((datum->change_g - 30.0) / datum->change_sigma_g, 2);
  }
  // Chi squared: its mean of 4000 is 1 within 3 sqrt(2 / 4000).
  EXPECT_NEAR(square / kRuns, 1.0, 0.07);
  EXPECT_NEAR(mass_square / kRuns, 1.0, 0.07);
}

TEST(DatumByTrialWeight, DoesNotCountTheOldDatumsUncertainty) {
  Balance balance;
  balance.unbalance_g = 30.0;
  balance.angle_rad = 1.2;
  balance.covariance_g2 << 0.3, 0.1, 0.1, 0.2;
  const Eigen::Matrix2d own = balance.covariance_g2;
  const EncoderConfig encoder{.pulses_per_turn = 96, .datum_rad = 0.3, .datum_sigma_rad = 0.2};
  add_variance(balance, 0.0, 0.2 * 0.2);
  const FoundUnbalance without = FoundUnbalance::from(balance, encoder);
  EXPECT_LT((without.covariance_g2 - own).norm(), 1e-12);
  EXPECT_LT((without.unbalance_g - polar(30.0, 1.2)).norm(), 1e-12);
  EXPECT_EQ(without.datum_rad, 0.3);
}

TEST(DatumByTrialWeight, SaysWhenTheWeightIsNotWhatTheDrivesFound) {
  const auto change = [](double grams) {
    return *datum_by_trial_weight(found({0.0, 0.0}, 0, 0, kExact), found(polar(grams, 1.0), 0, 0, kExact),
                                  {30.0, 1.0, 0.0});
  };
  EXPECT_TRUE(change(30.9).mass_agrees({30.0, 1.0, 0.0}));
  EXPECT_FALSE(change(33.0).mass_agrees({30.0, 1.0, 0.0}));
  EXPECT_FALSE(change(27.0).mass_agrees({30.0, 1.0, 0.0}));
  // Without a direction there is no datum.
  const Eigen::Matrix2d vague = 150.0 * Eigen::Matrix2d::Identity();
  EXPECT_FALSE(datum_by_trial_weight(found({0.0, 0.0}, 0, 0, vague), found({30.0, 0.0}, 0, 0, vague),
                                     {30.0, 0.0, 0.0}));
  EXPECT_FALSE(datum_by_trial_weight(found({9.0, 0.0}, 0, 0, kExact), found({9.0, 0.0}, 0, 0, kExact),
                                     {30.0, 0.0, 0.0}));
}

}  // namespace
}  // namespace roadbalance
