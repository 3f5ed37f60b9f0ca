#include "host/analysis/orders/fewer_samples.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace roadbalance {
namespace {

struct Given {
  std::optional<double> angle_rad;
  double value;
  std::uint32_t overload;
};

class FewerSamplesTest : public ::testing::Test {
 protected:
  static constexpr int kFactor = 6;
  static constexpr int kBehind = 8 * kFactor;

  void add(std::optional<double> angle_rad, double value, std::uint32_t overload = 0) {
    if (angle_rad) fewer.set_angle(0, *angle_rad);
    fewer.add(Eigen::VectorXd::Constant(1, value), overload);
  }
  std::vector<Given> given;
  FewerSamples fewer{1, kFactor, [this](const auto& angle_rad, const auto& values, std::uint32_t overload) {
                       given.push_back({angle_rad[0], values(0), overload});
                     }};
};

TEST_F(FewerSamplesTest, GiveWhatWasThereAtTheirAngleAndNothingThatFolds) {
  // Cycles a sample: what passes, and what would fold onto it.
  constexpr double kSlow = 0.2 / kFactor, kFast = (1.0 - 0.2) / kFactor;
  const auto wave = [](double cycles, int n) { return std::sin(2.0 * std::numbers::pi * cycles * n); };
  for (int n = 0; n < 1000; ++n) add(n, wave(kSlow, n) + wave(kFast, n));
  ASSERT_EQ(given.size(), static_cast<std::size_t>((1000 - 2 * kBehind - 1) / kFactor + 1));
  for (std::size_t k = 0; k < given.size(); ++k) {
    const int n = kBehind + static_cast<int>(k) * kFactor;
    ASSERT_EQ(given[k].angle_rad, n);
    ASSERT_NEAR(given[k].value, wave(kSlow, n), 3e-4);  // 2e-4 of what passes, -81 dB of what is stopped
  }
}

TEST_F(FewerSamplesTest, TellOverloadsOfAllTheyAreMadeOfAndAnglesThatAreNotKnown) {
  for (int n = 0; n < 300; ++n)
    add(n == 120 ? std::nullopt : std::optional<double>(n), 1.0, n == 150 ? 4U : 0U);
  for (std::size_t k = 0; k < given.size(); ++k) {
    const int n = kBehind + static_cast<int>(k) * kFactor;
    EXPECT_EQ(given[k].angle_rad.has_value(), n != 120);
    EXPECT_EQ(given[k].overload, std::abs(n - 150) <= kBehind ? 4U : 0U) << n;
    EXPECT_NEAR(given[k].value, 1.0, 1e-12);
  }
}

TEST_F(FewerSamplesTest, TellOverloadsOfEachChannelUpToAnInterruption) {
  for (int n = 0; n < 300; ++n) add(n, 1.0, (n == 100 ? 1U << 31 : 0U) | (n == 103 ? 3U : 0U));
  for (std::size_t k = 0; k < given.size(); ++k) {
    const int n = kBehind + static_cast<int>(k) * kFactor;
    EXPECT_EQ(given[k].overload,
              (std::abs(n - 100) <= kBehind ? 1U << 31 : 0U) | (std::abs(n - 103) <= kBehind ? 3U : 0U))
        << n;
  }
  add(300, 1.0, 7U);
  fewer.interrupt();
  given.clear();
  for (int n = 0; n < 300; ++n) add(n, 1.0);
  ASSERT_FALSE(given.empty());
  for (const Given& each : given) EXPECT_EQ(each.overload, 0U);
}

TEST(FewerSamples, PassAllWhereNoFewerAreWanted) {
  std::vector<Given> given;
  FewerSamples all(1, 1, [&](const auto& angle_rad, const auto& values, std::uint32_t overload) {
    given.push_back({angle_rad[0], values(0), overload});
  });
  for (int n = 0; n < 5; ++n) {
    if (n != 2) all.set_angle(0, n);
    all.add(Eigen::VectorXd::Constant(1, 10.0 * n), n == 3 ? 1U : 0U);
  }
  ASSERT_EQ(given.size(), 5U);
  for (int n = 0; n < 5; ++n) {
    const Given& each = given[static_cast<std::size_t>(n)];
    EXPECT_EQ(each.angle_rad, n == 2 ? std::nullopt : std::optional<double>(n));
    EXPECT_EQ(each.value, 10.0 * n);
    EXPECT_EQ(each.overload, n == 3 ? 1U : 0U);
  }
}

TEST_F(FewerSamplesTest, HaveNoAngleWhereItWasLostSinceTheOneBefore) {
  for (int n = 0; n < 300; ++n) {
    if (n == 121) fewer.lose_angle(0);
    add(n, 1.0);
  }
  for (std::size_t k = 0; k < given.size(); ++k) {
    const int n = kBehind + static_cast<int>(k) * kFactor;
    EXPECT_EQ(given[k].angle_rad.has_value(), n != 126) << n;
  }
}

TEST_F(FewerSamplesTest, HaveTheAnglesOfEachWheelForItself) {
  std::vector<std::array<std::optional<double>, 2>> angles;
  FewerSamples both(1, kFactor, [&](const auto& angle_rad, const auto&, std::uint32_t) {
    angles.push_back({angle_rad[0], angle_rad[1]});
  });
  both.follow(2);
  for (int n = 0; n < 300; ++n) {
    both.set_angle(0, n);
    if (n != 90) both.set_angle(1, -n);
    if (n == 121) both.lose_angle(1);
    both.add(Eigen::VectorXd::Constant(1, 1.0), 0);
  }
  ASSERT_EQ(angles.size(), static_cast<std::size_t>((300 - 2 * kBehind - 1) / kFactor + 1));
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const int n = kBehind + static_cast<int>(k) * kFactor;
    EXPECT_EQ(angles[k][0], n);
    EXPECT_EQ(angles[k][1], n == 90 || n == 126 ? std::nullopt : std::optional<double>(-n)) << n;
  }
}

TEST_F(FewerSamplesTest, AreNotMadeAcrossAnInterruption) {
  for (int n = 0; n < 200; ++n) add(n, 0.0);
  fewer.interrupt();
  given.clear();
  for (int n = 0; n < 2 * kBehind; ++n) add(n, 1.0);
  EXPECT_TRUE(given.empty());
  add(2 * kBehind, 1.0);
  ASSERT_EQ(given.size(), 1U);
  EXPECT_NEAR(given[0].value, 1.0, 1e-12);
  EXPECT_EQ(given[0].angle_rad, kBehind);
}

}  // namespace
}  // namespace roadbalance
