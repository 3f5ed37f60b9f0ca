#include "firmware/clock_place.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

constexpr std::uint32_t kFirst = 0x7F000001, kSecond = 0x7F000002, kForeign = 0x01020304;

TEST(ClockPlace, FollowsTheMachinesAddress) {
  std::uint32_t now = 0;
  ClockPlace place([&now] { return now; });
  EXPECT_NE(place.follow(), "");
  EXPECT_EQ(place.follow(), "") << "said once";
  EXPECT_EQ(place.socket(), nullptr);
  EXPECT_EQ(place.address().address, 0U);

  now = kFirst;
  EXPECT_EQ(place.follow(), "");
  ASSERT_NE(place.socket(), nullptr);
  const UdpAddress first = place.address();
  EXPECT_EQ(first, place.socket()->address());
  EXPECT_EQ(first.address, kFirst);
  EXPECT_EQ(place.follow(), "");
  EXPECT_EQ(place.address(), first) << "the same socket";

  now = 0;  // the cable is out
  EXPECT_EQ(place.follow(), "");
  EXPECT_EQ(place.address(), first);

  now = kSecond;
  EXPECT_EQ(place.follow(), "");
  EXPECT_EQ(place.address().address, kSecond);
  EXPECT_EQ(place.address(), place.socket()->address());
}

TEST(ClockPlace, StaysWhereItIsIfItCannotFollow) {
  std::uint32_t now = kFirst;
  ClockPlace place([&now] { return now; });
  EXPECT_EQ(place.follow(), "");
  now = kForeign;
  EXPECT_NE(place.follow().find("1.2.3.4"), std::string::npos);
  EXPECT_EQ(place.follow(), "") << "said once";
  EXPECT_EQ(place.address().address, kFirst);
}

}  // namespace
}  // namespace roadbalance
