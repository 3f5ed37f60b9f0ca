#include "common/test/bus_url.hpp"

#include <atomic>

#include "common/bus/process_port.hpp"

namespace roadbalance::test {

std::string bus_url() {
  static std::atomic<int> calls = 0;
  return "udpm://239.255.76.67:" + std::to_string(process_port(calls++)) + "?ttl=0";
}

}  // namespace roadbalance::test
