#include "common/gpio/device_place.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(DevicePlace, OfAChipOfTheMachineIsItsFolder) {
  for (const char* folder : {"/sys/devices/platform/gpio-pulse.1", "/sys/devices/pci0000:00/0000:00:1f.3",
                             "/sys/devices/platform/soc/fe804000.i2c/i2c-1/1-0020", "/sys/devices"})
    EXPECT_EQ(device_place(folder), folder);
}

TEST(DevicePlace, OnUsbIsTheInterfaceWhateverTheKernelNumbersBehindIt) {
  const std::string port = "/sys/devices/pci0000:00/0000:00:14.0/usb1/1-2/1-2.4/1-2.4:1.0";
  for (const char* behind : {"", "/0003:10C4:EA90.0007", "/0003:10C4:EA90.0008", "/ttyUSB3", "/i2c-7/7-0020"})
    EXPECT_EQ(device_place(port + behind), port);
  EXPECT_NE(device_place("/sys/devices/pci0000:00/0000:00:14.0/usb1/1-2/1-2.3/1-2.3:1.0/ttyUSB3"), port);
}

}  // namespace
}  // namespace roadbalance
