#include "tools/datum/typed_lines.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

class Typed : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(pipe(ends_), 0); }
  ~Typed() override {
    close(ends_[0]);
    hang_up();
  }
  void type(const std::string& text) {
    ASSERT_EQ(write(ends_[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  void hang_up() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }
  int ends_[2]{-1, -1};
};

TEST_F(Typed, AreGivenOneByOneAndTheLastWithoutItsEnd) {
  TypedLines lines(ends_[0]);
  EXPECT_FALSE(lines.terminal());
  EXPECT_FALSE(lines.next());
  type("45\r\n10:30\n");
  EXPECT_EQ(lines.next(), "45");
  EXPECT_EQ(lines.next(), "10:30");
  type("un");
  EXPECT_FALSE(lines.next()) << "somebody is still typing";
  type("do");
  hang_up();
  EXPECT_FALSE(lines.next());
  EXPECT_FALSE(lines.ended());
  EXPECT_EQ(lines.next(), "undo");
  EXPECT_TRUE(lines.ended());
  EXPECT_FALSE(lines.next());
}

TEST_F(Typed, HoldNobodyUpThatNeverEndAndTakeNoMoreMemory) {
  TypedLines lines(ends_[0]);
  // 60 kB lie ready in the pipe, and more would come.
  type(std::string(60'000, 'x'));
  EXPECT_FALSE(lines.next());
  char left[60'000];
  const ssize_t size = read(ends_[0], left, sizeof left);
  EXPECT_GT(size, 50'000) << "one read, then others have their turn";
  for (int k = 0; k < 10; ++k) {
    type(std::string(512, 'x'));
    EXPECT_FALSE(lines.next());
  }
  type("\n7\n");
  EXPECT_EQ(lines.next(), std::string(TypedLines::kLongestLine, 'x'));
  EXPECT_EQ(lines.next(), "7");
}

TEST(TypedLines, NeedSomebodyWhoCanAnswer) {
  EXPECT_THROW(TypedLines(-1), ConfigError);
}

}  // namespace
}  // namespace roadbalance
