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

TEST(BusRoute, AnAddressIsReadAsLcmReadsIt) {
  const auto whole = bus_address("udpm://239.1.2.3:4711?ttl=1&recv_buf_size=1000000");
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->group, 0xEF010203U);
  EXPECT_EQ(whole->port, 4711);
  EXPECT_EQ(whole->ttl, 1);
  EXPECT_EQ(whole->receive_buffer, 1'000'000);
  for (const char* defaults : {"udpm://", "udpm://?ttl=0", "udpm://239.255.76.67", "udpm://:7667"}) {
    const auto bus = bus_address(defaults);
    ASSERT_TRUE(bus) << defaults;
    EXPECT_EQ(bus->group, 0xEFFF4C43U) << defaults;
    EXPECT_EQ(bus->port, 7667) << defaults;
    EXPECT_EQ(bus->ttl, 0) << defaults;
    EXPECT_EQ(bus->receive_buffer, 4194304) << defaults << ": LCM's own default is what the kernel gives";
  }
  for (const char* none : {"", "memq://", "udpm://nowhere:1", "udpm://239.1.2.3:port",
                           "udpm://239.1.2.3:99999", "udpm://239.1.2.3?recv_buf_size=much",
                           "udpm://239.1.2.3?ttl=far", "udpm://239.1.2.3?ttl=256", "udpm://239.1.2.3?ttl=-1"})
    EXPECT_FALSE(bus_address(none)) << none;
}

TEST(BusRoute, ABusWithoutAddressesHasNone) {
  EXPECT_EQ(address_on_bus("memq://"), 0U);
  EXPECT_EQ(address_on_bus("udpm://nowhere:7667"), 0U);
  EXPECT_EQ(address_on_bus(""), 0U);
}

}  // namespace
}  // namespace roadbalance
