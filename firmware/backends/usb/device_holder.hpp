#pragma once

#include <string>

namespace roadbalance {

/// Which processes have a device file open, for people: "rb-node (process 812)".  Of other users' processes
/// only root learns.
std::string device_holder(const std::string& path);

}  // namespace roadbalance
