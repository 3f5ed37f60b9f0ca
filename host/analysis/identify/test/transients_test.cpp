#include "host/analysis/identify/transients.hpp"

#include <gtest/gtest.h>

#include <random>

namespace roadbalance {
namespace {

constexpr double kRate_hz = 500.0;
constexpr std::uint64_t kSeed = 3;

Eigen::MatrixXd noise(Eigen::Index channels, Eigen::Index samples) {
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(channels, samples, [&] { return normal(random); });
}

TEST(Transients, GaussianMotionIsQuiet) {
  const Eigen::ArrayXd quiet = quiet_samples(noise(4, 120000), kRate_hz);
  // Beyond five sigma lies a sample in 1.7 million; a tenth of four minutes would be twenty such.
  EXPECT_GT(quiet.mean(), 0.99);
}

// The loudest sample of a knock decides, not how loud it is: the robust scale does not feel it.
TEST(Transients, KnockIsCutFromBeforeUntilAfterIt) {
  for (const double size : {30.0, 3000.0}) {
    Eigen::MatrixXd carriers = noise(4, 10000);
    carriers(2, 5000) += size;
    const Eigen::ArrayXd quiet = quiet_samples(carriers, kRate_hz);
    EXPECT_EQ(quiet(4874), 1.0);
    EXPECT_EQ(quiet(4876), 0.0);
    EXPECT_EQ(quiet(5000), 0.0);
    EXPECT_EQ(quiet(5399), 0.0);
    EXPECT_EQ(quiet(5600), 1.0);
    EXPECT_GT(quiet.mean(), 0.94);
  }
}

TEST(Transients, KnockAtAnEndIsCutAsFarAsThereAreSamples) {
  for (const Eigen::Index at : {0, 9999}) {
    Eigen::MatrixXd carriers = noise(2, 10000);
    carriers(0, at) += 100.0;
    const Eigen::ArrayXd quiet = quiet_samples(carriers, kRate_hz);
    EXPECT_EQ(quiet(at), 0.0);
    EXPECT_GT(quiet.mean(), 0.94);
  }
}

TEST(Transients, SlowMotionOfAnySizeIsNoKnock) {
  Eigen::MatrixXd carriers = noise(1, 10000);
  for (Eigen::Index t = 0; t < carriers.cols(); ++t)
    carriers(0, t) += 20.0 * std::sin(2.0 * 3.141592653589793 * 1.0 * static_cast<double>(t) / kRate_hz);
  EXPECT_GT(quiet_samples(carriers, kRate_hz).mean(), 0.99);
}

TEST(Transients, NothingIsQuietOfNothing) {
  EXPECT_EQ(quiet_samples(Eigen::MatrixXd(4, 0), kRate_hz).size(), 0);
}

}  // namespace
}  // namespace roadbalance
