#include "host/recorder/incarnation.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "common/record/file.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

class IncarnationTest : public ::testing::Test {
 protected:
  std::vector<std::int64_t> stored() const { return stored_incarnations(work.path()); }
  test::TemporaryDirectory work;
};

TEST_F(IncarnationTest, EachNumberThatARecorderHadIsKnownAndTheHighestIsTheLast) {
  EXPECT_TRUE(stored().empty());
  EXPECT_EQ(stored_incarnation(work.path()), 0);
  EXPECT_EQ(next_incarnation(work.path(), 100), 100);
  EXPECT_EQ(next_incarnation(work.path(), 50), 101) << "the wall clock was set back";
  EXPECT_EQ(raise_incarnation(work.path(), 700), 701);
  EXPECT_EQ(stored_incarnation(work.path()), 701);
  EXPECT_EQ(stored(), (std::vector<std::int64_t>{100, 101, 701}));
}

TEST_F(IncarnationTest, OneThatIsStoredAgainStandsOnceInItsPlace) {
  for (const std::int64_t number : {100, 200, 100}) keep_incarnation(work.path(), number);
  EXPECT_EQ(stored(), (std::vector<std::int64_t>{100, 200}));
}

TEST_F(IncarnationTest, OfAThousandThatWereNeverObeyedTheLatestStay) {
  std::string text;
  for (int number = 1; number <= 1024; ++number) text += std::to_string(number) + "\n";
  std::ofstream(work.path() / kIncarnationFile) << text;
  EXPECT_EQ(next_incarnation(work.path(), 0), 1025);
  const auto numbers = stored();
  ASSERT_EQ(numbers.size(), 1024u);
  EXPECT_EQ(numbers.front(), 2);
  EXPECT_EQ(numbers.back(), 1025);
}

TEST_F(IncarnationTest, WhatIsNoListOfNumbersIsRefusedByName) {
  for (const char* text :
       {"", "\n", "7", "7\n\n", "7\nx\n", "0\n", "-7\n", "7 \n", "99999999999999999999\n"}) {
    std::ofstream(work.path() / kIncarnationFile) << text;
    try {
      (void)stored();
      ADD_FAILURE() << "taken: " << text;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(kIncarnationFile), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace roadbalance
