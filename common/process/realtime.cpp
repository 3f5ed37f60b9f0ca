#include "common/process/realtime.hpp"

#include <cerrno>
#include <system_error>

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

namespace roadbalance {

std::vector<std::string> enter_realtime(int priority) {
  std::vector<std::string> refused;
  const auto refuse = [&](const std::string& what, int error) {
    refused.push_back(what + ": " + std::generic_category().message(error) +
                      "; \"rb doctor\" says how to allow it");
  };
  // First: it takes long where there is much memory, and with priority it would hold up whoever serves
  // another device.
  if (mlockall(MCL_CURRENT) != 0) refuse("keeping memory in RAM", errno);
  const sched_param parameter{.sched_priority = priority};
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter); error != 0)
    refuse("real-time priority " + std::to_string(priority), error);
  return refused;
}

void leave_realtime() {
  const sched_param parameter{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &parameter);  // never refused
}

}  // namespace roadbalance
