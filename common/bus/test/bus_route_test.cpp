#include "common/bus/bus_route.hpp"

#include <gtest/gtest.h>

#include "common/bus/bus.hpp"

namespace roadbalance {
namespace {

TEST(BusRoute, LeadsOverTheInterfaceOfTheRoute) {
  EXPECT_EQ(address_on_bus("udpm://127.0.0.9:7667?ttl=0"), 0x7F000001U);  // all of 127/8 is this machine
  EXPECT_NE(address_on_bus(default_bus_url()), 0U);  // no test of the bus passes without a multicast route
  EXPECT_EQ(address_on_bus("udpm://"), address_on_bus("udpm://239.255.76.67:7667"));
}

TEST(BusRoute, ABusWithoutAddressesHasNone) {
  EXPECT_EQ(address_on_bus("memq://"), 0U);
  EXPECT_EQ(address_on_bus("udpm://nowhere:7667"), 0U);
  EXPECT_EQ(address_on_bus(""), 0U);
}

}  // namespace
}  // namespace roadbalance
