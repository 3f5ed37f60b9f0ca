#include "hil_tests/network/cable.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace roadbalance::test {
namespace {

using std::chrono::microseconds;

constexpr int kFrames = 20'000;

WallTime at(std::int64_t us) {
  return WallTime() + microseconds(us);
}

/// Frames that each end hears of kFrames numbered ones that end 0 sends, one every 100 us.
struct Heard {
  explicit Heard(Cable& cable) {
    for (int k = 0; k < kFrames; ++k) {
      const std::array<std::uint8_t, 2> number{static_cast<std::uint8_t>(k >> 8),
                                               static_cast<std::uint8_t>(k)};
      cable.take(0, number, at(100 * k));
      collect(cable, at(100 * k));
    }
    collect(cable, at(100 * kFrames + 1'000'000));
  }
  void collect(Cable& cable, WallTime now) {
    while (const auto frame = cable.arrived(now))
      end.at(frame->to).push_back(256 * frame->bytes[0] + frame->bytes[1]);
  }
  std::array<std::vector<int>, 3> end;
};

TEST(Cable, WithoutFaultsCarriesEveryFrameInOrderToAllOthers) {
  Cable cable(3, 1);
  const Heard heard(cable);
  EXPECT_TRUE(heard.end[0].empty()) << "nobody hears himself";
  for (std::size_t end : {1u, 2u}) {
    ASSERT_EQ(heard.end[end].size(), static_cast<std::size_t>(kFrames));
    for (int k = 0; k < kFrames; ++k) ASSERT_EQ(heard.end[end][static_cast<std::size_t>(k)], k);
  }
}

// Counts of independent draws: within five standard deviations of a binomial distribution.
TEST(Cable, LosesAndDoublesWithTheGivenProbabilitiesForEachEndByItself) {
  Cable cable(3, 1);
  cable.set_faults(0, {.loss = 0.3, .duplicates = 0.05});
  const Heard heard(cable);
  EXPECT_NE(heard.end[1], heard.end[2]);
  const auto near = [](std::int64_t count, double draws, double p) {
    EXPECT_NEAR(static_cast<double>(count), draws * p, 5 * std::sqrt(draws * p * (1 - p)));
  };
  near(cable.counts().lost, 2.0 * kFrames, 0.3);
  near(cable.counts().duplicated, 2.0 * kFrames * 0.7, 0.05);
  EXPECT_EQ(cable.counts().carried, 2 * kFrames - cable.counts().lost + cable.counts().duplicated);
}

TEST(Cable, DifferentDelaysReorder) {
  Cable cable(2, 1);
  cable.set_faults(0, {.shortest = microseconds(1000), .longest = microseconds(2000)});
  cable.take(0, std::array<std::uint8_t, 1>{0}, at(0));
  EXPECT_FALSE(cable.arrived(at(999)));
  EXPECT_TRUE(cable.arrived(at(2000)));
  const Heard heard(cable);
  ASSERT_EQ(heard.end[1].size(), static_cast<std::size_t>(kFrames));
  EXPECT_FALSE(std::is_sorted(heard.end[1].begin(), heard.end[1].end()));
  int farthest = 0;
  for (int k = 0; k < kFrames; ++k)
    farthest = std::max(farthest, std::abs(heard.end[1][static_cast<std::size_t>(k)] - k));
  EXPECT_LE(farthest, 10) << "a millisecond is ten frames";
}

TEST(Cable, APulledEndNeitherHearsNorIsHeard) {
  Cable cable(3, 1);
  cable.set_faults(0, {.shortest = microseconds(500), .longest = microseconds(500)});
  const std::array<std::uint8_t, 1> frame{7};
  cable.take(0, frame, at(0));  // under way when the end is pulled
  cable.pull(1);
  cable.take(0, frame, at(100));
  cable.take(1, frame, at(200));
  for (int k = 0; k < 2; ++k) EXPECT_EQ(cable.arrived(at(1000)).value().to, 2u);
  EXPECT_FALSE(cable.arrived(at(1000)));
  cable.plug(1);
  cable.take(1, frame, at(2000));
  EXPECT_EQ(cable.arrived(at(2000)).value().to, 0u);
  EXPECT_EQ(cable.arrived(at(2000)).value().to, 2u);
}

}  // namespace
}  // namespace roadbalance::test
