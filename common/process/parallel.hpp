#pragma once

#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

namespace roadbalance {

/// Runs processes side by side (occam's PAR): the first to throw stops the rest; wait() rethrows it.
///
/// A process whose first parameter is a std::stop_token gets this parallel's.
class Parallel {
 public:
  Parallel() = default;
  Parallel(const Parallel&) = delete;
  Parallel& operator=(const Parallel&) = delete;
  ~Parallel() {
    stop_.request_stop();
    join();
  }

  template <typename Process, typename... Args>
  void run(Process&& process, Args&&... args) {
    threads_.emplace_back([this, process = std::forward<Process>(process),
                           ... args = std::forward<Args>(args)]() mutable {
      try {
        if constexpr (std::is_invocable_v<Process&, std::stop_token, Args...>)
          std::invoke(process, stop_.get_token(), std::move(args)...);
        else
          std::invoke(process, std::move(args)...);
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
        stop_.request_stop();
      }
    });
  }

  void request_stop() { stop_.request_stop(); }
  std::stop_token stop_token() const { return stop_.get_token(); }

  /// Waits for all processes.  @throws what the first failing one threw
  void wait() {
    join();
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

 private:
  void join() {
    for (auto& thread : threads_)
      if (thread.joinable()) thread.join();
  }

  std::stop_source stop_;
  std::mutex mutex_;
  std::exception_ptr failure_;
  std::vector<std::thread> threads_;
};

}  // namespace roadbalance
