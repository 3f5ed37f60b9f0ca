#include "host/analysis/identify/drive_sums.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "host/analysis/identify/confidence.hpp"
#include "host/analysis/identify/drive_groups.hpp"
#include "host/analysis/identify/estimate_covariance.hpp"

namespace roadbalance {
namespace {

DriveMoments section(double speed_m_s, double value) {
  DriveMoments m;
  m.seconds = 10.0;
  m.speed_seconds = 10.0 * speed_m_s;
  m.sections = 1;
  m.chassis[3].w1(2) = value;
  m.chassis_power[3] = 2.0 * value;
  m.wheel[1].tyre.w0(4) = 3.0 * value;
  m.wheel[1].tyre_unbalance = {4.0 * value, 5.0 * value};
  m.wheel[2].tyre.w2(6) = 6.0 * value;
  m.harmonic.normal(1, 2) = {7.0 * value, 8.0 * value};
  m.harmonic.right[2][3].w1(5) = {9.0 * value, -value};
  m.body.right(1) = {value, 0.1};
  return m;
}

DriveSums drive(int sections) {
  DriveSums sums(2.0);
  for (int i = 0; i < sections; ++i) sums.classes.add(section(30.0 + i % 3 * 2.0, 0.1 * i + 1.0 / 3.0));
  sums.drift.seen[0][3].set(17).set(359);
  sums.time_ns = 1234567890123;
  sums.state = Unknown::kNone;
  sums.refusal = "none, \"really\"";
  sums.common_sigma_rad = {0.0, 0.01, 0.0, 1e-300};
  return sums;
}

TEST(DriveSums, ComeBackBitForBit) {
  const DriveSums before = drive(25);
  const std::vector<char> bytes = encode(before);
  const auto after = decode_drive_sums(bytes);
  ASSERT_TRUE(after);
  EXPECT_EQ(encode(*after), bytes);
  EXPECT_EQ(after->classes.sections(), 25);
  EXPECT_EQ(after->refusal, before.refusal);
  EXPECT_EQ(after->time_ns, before.time_ns);
  EXPECT_EQ(after->drift.drift_rad(0, 3), before.drift.drift_rad(0, 3));
  const DriveMoments a = after->classes.total(), b = before.classes.total();
  EXPECT_EQ(a.harmonic.right[2][3].w1(5), b.harmonic.right[2][3].w1(5));
  EXPECT_EQ(a.wheel[2].tyre.w2(6), b.wheel[2].tyre.w2(6));
}

TEST(DriveSums, RefusesWhatIsCutShortOrHasMore) {
  std::vector<char> bytes = encode(drive(4));
  for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 97)
    EXPECT_FALSE(decode_drive_sums(std::span(bytes).first(size))) << size;
  bytes.push_back(0);
  EXPECT_FALSE(decode_drive_sums(bytes));
}

/// A drive's equations of suspension and tyres may be multiplied; those of unbalances carry their weights.
TEST(DriveSums, WeighTheRoadOnlyWhereEquationsAreNoughtWithAnyFactor) {
  DriveSums sums = drive(7);
  const DriveMoments before = sums.classes.total();
  sums.classes.weigh_road(4.0);
  const DriveMoments after = sums.classes.total();
  EXPECT_EQ(after.chassis[3].w1(2), 4.0 * before.chassis[3].w1(2));
  EXPECT_EQ(after.chassis_power[3], 4.0 * before.chassis_power[3]);
  EXPECT_EQ(after.wheel[1].tyre_unbalance, 4.0 * before.wheel[1].tyre_unbalance);
  EXPECT_EQ(after.wheel[2].tyre.w2(6), 4.0 * before.wheel[2].tyre.w2(6));
  EXPECT_EQ(after.harmonic.normal(1, 2), before.harmonic.normal(1, 2));
  EXPECT_EQ(after.body.right(1), before.body.right(1));
  EXPECT_EQ(after.seconds, before.seconds);
}

TEST(DriveGroups, HoldEveryDriveOnceAndNoMoreGroupsThanTheirMost) {
  DriveGroups groups;
  for (int i = 0; i < 90; ++i) groups.add(drive(2 + i % 5).classes);
  ASSERT_EQ(groups.size(), DriveGroups::kMost);
  int sections = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) sections += groups.total(g).sections;
  EXPECT_EQ(sections, 18 * (2 + 3 + 4 + 5 + 6));
  int rest = 0;
  for (const DriveMoments& each : groups.without(7)) rest += each.sections;
  EXPECT_EQ(rest + groups.total(7).sections, sections);
}

/// For a weighted mean of values whose variances are 1 / weight, the mean estimate by leaving them out is
/// the variance of that mean, 1 / sum of weights, however unequal the weights are.
TEST(BetweenDrives, TellsTheVarianceOfAWeightedMean) {
  Eigen::VectorXd weight(4);
  weight << 1.0, 2.0, 5.0, 20.0;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  double mean = 0.0;
  constexpr int kRuns = 20000;
  for (int run = 0; run < kRuns; ++run) {
    Eigen::VectorXd x(4);
    for (int i = 0; i < 4; ++i) x(i) = 3.0 + normal(random) / std::sqrt(weight(i));
    Eigen::VectorXd whole(1);
    whole << x.dot(weight) / weight.sum();
    Eigen::MatrixXd left_out(1, 4);
    for (int i = 0; i < 4; ++i)
      left_out(0, i) = (x.dot(weight) - x(i) * weight(i)) / (weight.sum() - weight(i));
    mean += variance_between(whole, left_out, weight)(0) / kRuns;
  }
  // chi^2 of three degrees of freedom or so: sqrt(2/3) of the value a run, 1/141 of that in the mean.
  EXPECT_NEAR(mean * weight.sum(), 1.0, 0.03);
}

/// Drives that differ by more than they scatter in themselves: all by one variance, whatever they weigh.  The
/// mean's is then that times sum p^2; and drives' shares p count no more than they are.
TEST(BetweenDrives, TellsDrivesThatDifferByMoreThanTheirWeightsSay) {
  Eigen::VectorXd p(6);
  p << 0.02, 0.05, 0.2, 0.22, 0.25, 0.26;
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  double mean = 0.0;
  constexpr int kRuns = 20000;
  for (int run = 0; run < kRuns; ++run) {
    Eigen::VectorXd x(6);
    for (int i = 0; i < 6; ++i) x(i) = normal(random);
    const Eigen::VectorXd whole = Eigen::VectorXd::Constant(1, x.dot(p));
    Eigen::MatrixXd left_out(1, 6);
    for (int i = 0; i < 6; ++i) left_out(0, i) = (x.dot(p) - x(i) * p(i)) / (1.0 - p(i));
    mean += variance_between(whole, left_out, p)(0) / kRuns;
  }
  double expected = 0.0;  // of p^2 / (1 - p) (x_j - x)^2
  for (int i = 0; i < 6; ++i) expected += p(i) * p(i) / (1.0 - p(i)) * (1.0 - 2.0 * p(i) + p.squaredNorm());
  EXPECT_NEAR(mean / expected, 1.0, 0.03);
  // No less than the truth by more than a tenth: the delete-m_j jackknife gives 0.75 of it.
  EXPECT_GT(mean, 0.9 * p.squaredNorm());
}

TEST(BetweenDrives, WidensByTheQuantileOfF) {
  // 95 % quantiles of F(2, m) of the tables: M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions,
  // table 26.9.  For chi^2 with two degrees of freedom it is 5.99.
  EXPECT_NEAR(few_drives_factor(2.0) * 5.99 / 2.0, 19.00, 0.02);
  EXPECT_NEAR(few_drives_factor(4.0) * 5.99 / 2.0, 5.14, 0.01);
  EXPECT_NEAR(few_drives_factor(16.0) * 5.99 / 2.0, 3.32, 0.01);
  EXPECT_NEAR(few_drives_factor(1e6), 1.0, 1e-4);
  EXPECT_EQ(few_drives_factor(1.1), few_drives_factor(2.0));
}

}  // namespace
}  // namespace roadbalance
