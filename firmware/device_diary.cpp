#include "firmware/device_diary.hpp"

namespace roadbalance {

DeviceDiary::DeviceDiary(std::vector<const DeviceReport*> reports) {
  for (const DeviceReport* report : reports) pages_.push_back({.report = report});
}

void DeviceDiary::look(const std::function<void(const std::string&)>& warn) {
  for (Page& page : pages_)
    for (std::size_t k = 0; k < kDeviceCounters; ++k) {
      const auto counter = static_cast<DeviceCounter>(k);
      const std::int64_t now = page.report->of(counter);
      if (now == page.reported[k]) continue;
      page.reported[k] = now;
      warn(page.report->device() + ": " + sentence(counter, now));
    }
}

}  // namespace roadbalance
