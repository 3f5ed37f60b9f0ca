#include "firmware/backends/front_ends.hpp"

#include "firmware/backends/gpio/gpio_source.hpp"
#include "firmware/backends/replay/front_end.hpp"
#include "firmware/backends/socketcan/open_can.hpp"
#include "firmware/backends/usb/usb_front_end.hpp"

namespace roadbalance {

FrontEndRegistry real_front_ends(const std::function<void(const std::string&)>& warn,
                                 const std::function<void(const std::string&)>& inform) {
  FrontEndRegistry front_ends;
  front_ends.add("replay",
                 [inform](const FrontEndRequest& request) { return open_replay_front_end(request, inform); });
  front_ends.add("can", [warn](const FrontEndRequest& request) { return open_can(request, warn); });
  front_ends.add("usb", [warn](const FrontEndRequest& request) { return open_usb_front_end(request, warn); });
  front_ends.add("gpio", [warn](const FrontEndRequest& request) { return open_gpio(request, warn); });
  return front_ends;
}

}  // namespace roadbalance
