#include "firmware/backends/usb/usb_address.hpp"

#include <gtest/gtest.h>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

TEST(UsbAddress, NamesTheBoardsOfANode) {
  const auto any = UsbAddress::parse("1209:0001");
  EXPECT_EQ(any.vendor, 0x1209);
  EXPECT_EQ(any.product, 1);
  EXPECT_EQ(any.boards(), 1u);
  EXPECT_EQ(any.of_board(0), "usb:1209:0001");

  const auto pair = UsbAddress::parse("1209:1:A17+B2");
  EXPECT_EQ(pair.boards(), 2u);
  EXPECT_EQ(pair.of_board(1), "usb:1209:0001:B2");
  EXPECT_EQ(UsbAddress::parse("1209:5242:X:Y").serial[0], "X:Y");
}

TEST(UsbAddress, RefusesWhatIsNoneNamingIt) {
  for (const auto& [address, named] :
       std::vector<std::pair<std::string, std::string>>{{"", "no product"},
                                                        {"1209", "no product"},
                                                        {"12g9:1", "'12g9'"},
                                                        {":1", "''"},
                                                        {"1209:00001", "'00001'"},
                                                        {"0x1209:1", "'0x1209'"},
                                                        {"12090:1", "'12090'"},
                                                        {"1209:1:", "''"},
                                                        {"1209:1:A+", "''"},
                                                        {"1209:1:A+A", "A stands twice"},
                                                        {"1209:1:A+B+C", "3 boards"},
                                                        {"1209:1:ABCDEFGHIJKLMNOPQ", "'ABCDEFGHIJKLMNOPQ'"}})
    try {
      UsbAddress::parse(address);
      ADD_FAILURE() << address << " was taken";
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("usb:" + address), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace roadbalance
