#include "tools/rb/wake_up.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <thread>

#include "common/process/realtime.hpp"

namespace roadbalance {
namespace {

struct Sleeper {
  std::chrono::nanoseconds worst{};
  bool realtime = false;

  void sleep_for(std::chrono::milliseconds duration, int priority) {
    const sched_param parameter{.sched_priority = priority};
    realtime = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter) == 0;
    auto next = std::chrono::steady_clock::now();
    for (const auto end = next + duration; next < end;) {
      next += std::chrono::milliseconds(1);
      std::this_thread::sleep_until(next);
      const auto late = std::chrono::steady_clock::now() - next;
      worst = std::max(worst, std::chrono::duration_cast<std::chrono::nanoseconds>(late));
      if (late > std::chrono::milliseconds(1)) next += late;  // those it slept through are not late, too
    }
  }
};

}  // namespace

WakeUpMeasurement measure_wake_ups(std::chrono::milliseconds duration) {
  Sleeper interrupt_thread, reader;
  {
    const std::jthread first([&] { interrupt_thread.sleep_for(duration, kInterruptPriority); });
    const std::jthread second([&] { reader.sleep_for(duration, kDevicePriority); });
  }
  return {.worst = {.interrupt_thread = interrupt_thread.worst, .reader = reader.worst},
          .duration = duration,
          .realtime = interrupt_thread.realtime && reader.realtime};
}

}  // namespace roadbalance
