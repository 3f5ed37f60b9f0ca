#include "hil_tests/guest/running_module.hpp"

#include <time.h>

#include "firmware/backends/socketcan/accelerometer_frame.hpp"

namespace roadbalance::test {

RunningModule::RunningModule(const std::string& interface)
    : player_(interface), thread_([this](const std::stop_token& stop) { run(stop); }) {}

void RunningModule::run(const std::stop_token& stop) {
  timespec due{};
  clock_gettime(CLOCK_MONOTONIC, &due);
  for (std::uint32_t number = 0; !stop.stop_requested(); ++number) {
    due.tv_nsec += 1'000'000;
    if (due.tv_nsec >= 1'000'000'000) ++due.tv_sec, due.tv_nsec -= 1'000'000'000;
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
    if (lost_ > 0)
      --lost_;
    else
      player_.send(write_accelerometer({.sequence = number, .part = {}}, kFirstId));
  }
}

}  // namespace roadbalance::test
