#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/types/device_report.hpp"

namespace roadbalance {

/// Reports in sentences what devices have counted since it was last asked: "can:can0: was unplugged or went
/// down (2 times by now)".
class DeviceDiary {
 public:
  explicit DeviceDiary(std::vector<const DeviceReport*> reports);

  /// @param warn  gets a sentence for each counter that has moved
  void look(const std::function<void(const std::string&)>& warn);

 private:
  struct Page {
    const DeviceReport* report;
    std::array<std::int64_t, kDeviceCounters> reported{};
  };
  std::vector<Page> pages_;
};

}  // namespace roadbalance
