#include "host/recorder/space_watch.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using std::chrono::seconds;
using Event = SpaceWatch::Event;
constexpr std::int64_t kMB = 1'000'000;

class SpaceWatchTest : public ::testing::Test {
 protected:
  // Records so fast for so long; the disk's free space falls with it.  Counts the events.
  int record(seconds duration, std::int64_t bytes_per_s, Event event) {
    int events = 0;
    for (seconds t{0}; t < duration; ++t) {
      now += seconds(1);
      recorded += bytes_per_s;
      free -= bytes_per_s;
      events += watch.take(free, recorded, now) == event ? 1 : 0;
    }
    return events;
  }

  SpaceWatch watch{10 * kMB};
  WallTime now = WallTime(std::chrono::hours(1));
  std::int64_t recorded = 0;
  std::int64_t free = 0;
};

TEST_F(SpaceWatchTest, SaysHowLongTheSpaceBeyondTheReserveWillDo) {
  free = 1010 * kMB;
  record(seconds(100), kMB, Event::kNone);
  EXPECT_NEAR(watch.seconds_left(), 900.0, 1.0);
  EXPECT_EQ(watch.usable_bytes(), 900 * kMB);
}

TEST_F(SpaceWatchTest, DoesNotKnowARateAtFirstOrWithoutData) {
  free = 1000 * kMB;
  record(seconds(4), kMB, Event::kNone);
  EXPECT_LT(watch.seconds_left(), 0.0);
  record(seconds(100), 0, Event::kNone);
  EXPECT_LT(watch.seconds_left(), 0.0);
}

TEST_F(SpaceWatchTest, WarnsOnceAtSixtyFifteenAndFiveMinutes) {
  free = 4010 * kMB;
  EXPECT_EQ(record(seconds(100), kMB, Event::kWarning), 0);
  EXPECT_EQ(record(seconds(2900), kMB, Event::kWarning), 1);
  EXPECT_EQ(record(seconds(300), kMB, Event::kWarning), 1);
  EXPECT_EQ(record(seconds(600), kMB, Event::kWarning), 1);
  free += 10'000 * kMB;
  EXPECT_EQ(record(seconds(10), kMB, Event::kWarning), 0);
  free -= 10'000 * kMB;
  EXPECT_EQ(record(seconds(1), kMB, Event::kWarning), 1) << "there was enough meanwhile";
}

TEST_F(SpaceWatchTest, IsFullOnceAndFreeAgainOnlyWithSomeSpaceToSpare) {
  free = 20 * kMB;
  EXPECT_EQ(record(seconds(15), kMB, Event::kFull), 1);
  EXPECT_TRUE(watch.full());
  free = 10 * kMB + kMB;
  EXPECT_EQ(record(seconds(1), 0, Event::kFree), 0);
  free = 10 * kMB + 5 * kMB;
  EXPECT_EQ(record(seconds(5), 0, Event::kFree), 1);
  EXPECT_FALSE(watch.full());
}

TEST_F(SpaceWatchTest, IsFullForASecondAtLeastWhenAWriteFoundNoSpace) {
  free = 1000 * kMB;
  record(seconds(1), kMB, Event::kNone);
  EXPECT_EQ(watch.refuse(now), Event::kFull);
  EXPECT_EQ(watch.refuse(now), Event::kNone) << "once";
  EXPECT_EQ(watch.take(free, recorded, now + std::chrono::milliseconds(5000)), Event::kNone)
      << "no write has succeeded";
  watch.wrote();
  EXPECT_EQ(watch.take(free, recorded, now + std::chrono::milliseconds(900)), Event::kNone);
  EXPECT_TRUE(watch.full());
  EXPECT_EQ(watch.take(free, recorded, now + std::chrono::milliseconds(1000)), Event::kFree);
}

TEST_F(SpaceWatchTest, LearnsNothingFromADiskThatDoesNotSay) {
  EXPECT_EQ(watch.take(-1, 0, now), Event::kNone);
  EXPECT_FALSE(watch.full());
}

}  // namespace
}  // namespace roadbalance
