#include "common/gpio/device_place.hpp"

#include <cstddef>
#include <string_view>

namespace roadbalance {
namespace {

/// BUS-PORT.PORT:CONFIGURATION.INTERFACE, e.g. "1-2.4:1.0"; a PCI function has no hyphen, an I2C device no
/// colon.
bool is_usb_interface(std::string_view name) {
  const std::size_t hyphen = name.find('-');
  return hyphen != name.npos && name.find(':', hyphen) != name.npos &&
         name.find_first_not_of("0123456789.:-") == name.npos;
}

}  // namespace

std::string device_place(const std::string& folder) {
  for (std::size_t begin = 0, end = 0; end != folder.npos; begin = end + 1) {
    end = folder.find('/', begin);
    if (is_usb_interface(std::string_view(folder).substr(begin, end - begin))) return folder.substr(0, end);
  }
  return folder;
}

}  // namespace roadbalance
