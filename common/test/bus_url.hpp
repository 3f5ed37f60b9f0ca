#pragma once

#include <string>

namespace roadbalance::test {

/// A bus of its own for a test: loopback multicast on a port that depends on the process and the call, so
/// that tests running side by side do not receive one another.
std::string bus_url();

}  // namespace roadbalance::test
