#include "common/process/pause.hpp"

#include <condition_variable>
#include <mutex>

namespace roadbalance {

bool pause(const std::stop_token& stop, std::chrono::nanoseconds duration) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, duration, [] { return false; });
  return !stop.stop_requested();
}

}  // namespace roadbalance
