#include "common/test/bus_url.hpp"

#include <atomic>

#include <unistd.h>

namespace roadbalance::test {

std::string bus_url() {
  static std::atomic<int> calls = 0;
  const int port = 20'000 + (getpid() + 4'799 * calls++) % 20'000;
  return "udpm://239.255.76.67:" + std::to_string(port) + "?ttl=0&recv_buf_size=4194304";
}

}  // namespace roadbalance::test
