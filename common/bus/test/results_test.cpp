#include "common/bus/results.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/types/block.hpp"

namespace roadbalance {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(Results, ALevelThatIsNoNumberIsRefused) {
  const auto taken = [](auto spoil) {
    Level sent{.node = 2, .seconds = 0.1};
    spoil(sent);
    return decode_level(encode(sent)).has_value();
  };
  EXPECT_TRUE(taken([](Level&) {}));
  for (const double none : {kNaN, kInfinite, -kInfinite}) {
    EXPECT_FALSE(taken([&](Level& sent) { sent.seconds = none; })) << none;
    EXPECT_FALSE(taken([&](Level& sent) { sent.mean[7] = none; })) << none;
    EXPECT_FALSE(taken([&](Level& sent) { sent.rms[0] = none; })) << none;
    EXPECT_FALSE(taken([&](Level& sent) { sent.peak[kChannels - 1] = none; })) << none;
  }
  EXPECT_FALSE(taken([](Level& sent) { sent.seconds = -0.1; }));
  EXPECT_FALSE(taken([](Level& sent) { sent.rms[3] = -1e-9; }));
  EXPECT_FALSE(taken([](Level& sent) { sent.peak[3] = -1e-9; }));
  EXPECT_TRUE(taken([](Level& sent) { sent.mean[3] = -9.81; }));
}

TEST(Results, ASpeedMayBeUnknownAndNotInfinite) {
  Level sent{.node = 2, .speed_m_s = kNaN, .rotation_hz = {kNaN, -12.5}};
  const auto got = decode_level(encode(sent));
  ASSERT_TRUE(got);
  EXPECT_TRUE(std::isnan(got->speed_m_s));
  EXPECT_TRUE(std::isnan(got->rotation_hz[0]));
  EXPECT_EQ(got->rotation_hz[1], -12.5);
  sent.rotation_hz[1] = kInfinite;
  EXPECT_FALSE(decode_level(encode(sent)));
  sent.rotation_hz[1] = 0.0;
  sent.speed_m_s = -kInfinite;
  EXPECT_FALSE(decode_level(encode(sent)));
}

TEST(Results, AreOfNodesThatThereCanBe) {
  for (const std::int32_t node : {1, kLastNode}) {
    EXPECT_TRUE(decode_level(encode(Level{.node = node}))) << node;
    EXPECT_TRUE(decode_spectrum(encode(SpectrumPart{.node = node}))) << node;
  }
  for (const std::int32_t node : {INT32_MIN, -1, 0, kLastNode + 1, INT32_MAX}) {
    EXPECT_FALSE(decode_level(encode(Level{.node = node}))) << node;
    EXPECT_FALSE(decode_spectrum(encode(SpectrumPart{.node = node}))) << node;
  }
}

}  // namespace
}  // namespace roadbalance
