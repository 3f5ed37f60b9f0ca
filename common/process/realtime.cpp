#include "common/process/realtime.hpp"

#include <cerrno>
#include <system_error>

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

namespace roadbalance {

std::vector<std::string> enter_realtime(int priority) {
  std::vector<std::string> refused;
  // First: it takes long where there is much memory, and with priority it would hold up whoever serves
  // another device.
  if (mlockall(MCL_CURRENT) != 0)
    refused.push_back("keeping memory in RAM: " + std::generic_category().message(errno));
  const sched_param parameter{.sched_priority = priority};
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter); error != 0)
    refused.push_back("real-time priority " + std::to_string(priority) + ": " +
                      std::generic_category().message(error));
  return refused;
}

void leave_realtime() {
  const sched_param parameter{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &parameter);  // never refused
}

}  // namespace roadbalance
