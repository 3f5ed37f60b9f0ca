#pragma once

#include <string>

namespace roadbalance {

/// Where a device hangs, by which it is known again after it was unplugged: its folder in sysfs, of a USB
/// device only as far as the interface, for what is behind that the kernel numbers anew at each plugging.
///
/// @param folder  without links, e.g. "/sys/devices/pci0000:00/0000:00:14.0/usb1/1-2/1-2:1.0/i2c-7/7-0020"
std::string device_place(const std::string& folder);

}  // namespace roadbalance
