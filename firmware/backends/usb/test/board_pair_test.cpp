#include "firmware/backends/usb/board_pair.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

constexpr double kRateHz = 10'000.0;
constexpr std::uint32_t kTickHz = 10'000'000;

/// Scan `index` of a board whose timer began at `first` and is `ppm` fast; what it converted is `truth`.
BoardScan scan(std::int64_t index, std::uint64_t first, double ppm, std::int64_t truth) {
  BoardScan scan;
  scan.index = index;
  scan.ticks = first + static_cast<std::uint64_t>(static_cast<double>(truth) * 1000.0 * (1.0 + 1e-6 * ppm));
  scan.content.counts[0] = static_cast<std::int32_t>(truth);
  return scan;
}

class BoardPairTest : public testing::Test {
 protected:
  BoardPairTest() { pair.start({kTickHz, kTickHz}, kRateHz); }
  void add_first(std::int64_t k) { dropped += !pair.add(0, scan(k, 1'000'000, 60.0, k)); }
  void add_second(std::int64_t index, std::int64_t truth) {
    dropped += !pair.add(1, scan(index, 77, -60.0, truth));
  }
  /// Takes all common scans there are; they must be of the same conversion.
  int take() {
    int taken = 0;
    for (auto common = pair.front(); common.first; common = pair.front(), ++taken) {
      EXPECT_EQ(common.first->content.counts[0], common.second->content.counts[0]);
      pair.drop();
    }
    return taken;
  }
  BoardPair pair{2};
  int dropped = 0;  ///< scans that went because the other board's did not come
};

TEST_F(BoardPairTest, PutsScansOfTheSameConversionTogetherHoweverTheyArrive) {
  // As much as a board holds back before it loses something itself, and as much again on the way.
  constexpr int kLag = 2 * static_cast<int>(board::SampleRing::kScans) - 1;
  int taken = 0;
  for (std::int64_t k = 0; k < 30'000; ++k) {
    add_first(k);
    if (k >= kLag) add_second(k - kLag, k - kLag);
    taken += take();
  }
  EXPECT_EQ(taken, 30'000 - kLag);
  EXPECT_EQ(dropped, 0);
  EXPECT_TRUE(pair.aligned());
}

TEST_F(BoardPairTest, WhatOneBoardLostIsMissingOfBoth) {
  int taken = 0;
  for (std::int64_t k = 0; k < 9000; ++k) {
    if (k / 100 % 9 != 3) add_first(k);
    if (k / 100 % 9 != 7) add_second(k, k);
    taken += take();
  }
  EXPECT_EQ(taken, 7000);
  EXPECT_TRUE(pair.aligned());
}

TEST_F(BoardPairTest, NoticesAScanTooManyOrTooFew) {
  for (const int slip : {-1, 1}) {
    pair.start({kTickHz, kTickHz}, kRateHz);
    for (std::int64_t k = 0; k < 1000; ++k) add_first(k), add_second(k, k);
    EXPECT_EQ(take(), 1000);
    // From here on the second board's numbers are one off its conversions.
    for (std::int64_t k = 1000; k < 1010; ++k) add_first(k), add_second(k, k + slip);
    EXPECT_EQ(take(), 0) << slip;
    EXPECT_FALSE(pair.aligned());
  }
}

TEST_F(BoardPairTest, NoticesASlipBehindAHoleToo) {
  add_first(0), add_second(0, 0);
  EXPECT_EQ(take(), 1);
  add_first(2500), add_second(2500, 2499);
  EXPECT_EQ(take(), 0);
  EXPECT_FALSE(pair.aligned());
  pair.start({kTickHz, kTickHz}, kRateHz);
  add_first(0), add_second(0, 0);
  add_first(2500), add_second(2500, 2500);
  EXPECT_EQ(take(), 2);
}

TEST_F(BoardPairTest, ABoardThatSendsNothingDoesNotStopTheOther) {
  for (std::int64_t k = 0; k < 5000; ++k) add_first(k);
  for (std::int64_t k = 0; k < 6000; ++k) {
    if (k >= 5000) add_first(k);
    add_second(k, k);
  }
  EXPECT_EQ(take(), static_cast<int>(BoardPair::kScans)) << "the newest that were kept of both";
  EXPECT_EQ(dropped, 2 * (6000 - static_cast<int>(BoardPair::kScans)));
}

TEST(BoardPair, OneBoardsScansPassAsTheyCome) {
  BoardPair pair(1);
  pair.start({kTickHz, 0}, kRateHz);
  for (const std::int64_t k : {0, 1, 2, 9, 10}) EXPECT_TRUE(pair.add(0, scan(k, 5, 0, k)));
  for (const std::int64_t k : {0, 1, 2, 9, 10}) {
    ASSERT_TRUE(pair.front().first);
    EXPECT_EQ(pair.front().first->index, k);
    EXPECT_EQ(pair.front().second, nullptr);
    pair.drop();
  }
  EXPECT_EQ(pair.front().first, nullptr);
}

}  // namespace
}  // namespace roadbalance
