#include "hil_tests/guest/running_module.hpp"

#include <chrono>

#include "common/types/clocks.hpp"

namespace roadbalance::test {

RunningModule::RunningModule(const std::string& interface)
    : module_(interface, true), thread_([this](const std::stop_token& stop) { run(stop); }) {}

std::string RunningModule::wiring(const std::string& interface) {
  return "[[node.can]]\ninterface = \"" + interface +
         "\"\nrole = \"sensor\"\naccelerometer_id = " + std::to_string(AccelerometerModule::kFirstId) + "\n";
}

void RunningModule::run(const std::stop_token& stop) {
  for (WallTime due = WallClock::now(); !stop.stop_requested();) {
    std::this_thread::sleep_until(due += std::chrono::milliseconds(1));
    if (lost_ > 0) {
      --lost_;
      module_.skip(1);
    } else {
      module_.convert();
    }
  }
}

}  // namespace roadbalance::test
