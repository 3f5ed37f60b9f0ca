#include "host/recorder/failure_policy.hpp"

#include <gtest/gtest.h>

#include <cerrno>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

std::system_error failed_write(int code) {
  return {code, std::generic_category(), "write"};
}

class FailurePolicyTest : public ::testing::Test {
 protected:
  FailurePolicy policy;
  WallTime now = WallTime(std::chrono::hours(1));
};

TEST_F(FailurePolicyTest, TriesAtOnceAfterOneFailureAndOnceASecondAfterTwo) {
  EXPECT_FALSE(policy.fail(failed_write(EIO), now).lets_go);
  EXPECT_FALSE(policy.is_failing());
  EXPECT_TRUE(policy.may_try(now));
  EXPECT_TRUE(policy.fail(failed_write(EIO), now).lets_go) << "so that it can be unmounted";
  EXPECT_TRUE(policy.is_failing());
  EXPECT_FALSE(policy.may_try(now + milliseconds(999)));
  EXPECT_TRUE(policy.may_try(now + seconds(1)));
}

TEST_F(FailurePolicyTest, TwoFailuresFarApartAreTwoTimesOne) {
  (void)policy.fail(failed_write(EIO), now);
  EXPECT_FALSE(policy.succeed());
  (void)policy.fail(failed_write(EIO), now + seconds(10));
  EXPECT_FALSE(policy.is_failing());
}

TEST_F(FailurePolicyTest, TheThirdInARowGoesElsewhereAndIsNotReported) {
  EXPECT_TRUE(policy.fail(failed_write(EIO), now).is_reported);
  const auto second = policy.fail(failed_write(EIO), now);
  EXPECT_TRUE(second.is_reported);
  EXPECT_FALSE(second.goes_elsewhere);
  const auto third = policy.fail(failed_write(EIO), now + seconds(1));
  EXPECT_FALSE(third.is_reported);
  EXPECT_TRUE(third.goes_elsewhere);
  EXPECT_TRUE(policy.succeed());
  EXPECT_FALSE(policy.is_failing());
  EXPECT_EQ(policy.failures(), 3);
  EXPECT_TRUE(policy.fail(failed_write(EIO), now + seconds(60)).is_reported) << "in a row are none any more";
}

TEST_F(FailurePolicyTest, ADiskThatIsFullIsKeptOpenAndLeadsNowhereElse) {
  for (int failures = 0; failures < 3; ++failures) {
    const auto decision = policy.fail(failed_write(failures % 2 == 0 ? ENOSPC : EDQUOT), now);
    EXPECT_TRUE(decision.is_full);
    EXPECT_FALSE(decision.lets_go);
    EXPECT_FALSE(decision.goes_elsewhere);
  }
}

TEST_F(FailurePolicyTest, ADiskThatIsNotThereIsLetGoOfAtOnce) {
  for (const int code : {ENOENT, ENODEV}) {
    const auto decision = FailurePolicy().fail(failed_write(code), now);
    EXPECT_TRUE(decision.has_no_place);
    EXPECT_TRUE(decision.lets_go);
  }
}

}  // namespace
}  // namespace roadbalance
