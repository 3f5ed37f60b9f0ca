#pragma once

#include <csignal>
#include <latch>
#include <stop_token>
#include <thread>

#include <pthread.h>

namespace roadbalance {

/// Turns SIGINT, SIGTERM and SIGHUP into a request to stop; SIGHUP not where it is ignored (nohup).
///
/// To be made first in main, before any other thread: it blocks these signals in the calling thread, and
/// threads inherit that.  Its own thread does nothing until one comes, so that a fork finds no lock held.
/// Programs started with exec inherit it too: see start of common/process/child.cpp.
class StopOnSignal {
 public:
  StopOnSignal() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    struct sigaction hang_up {};
    if (sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler != SIG_IGN)
      sigaddset(&signals_, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    waiter_ = std::jthread([this](std::stop_token ended) {
      const std::stop_callback wake(ended, [self = pthread_self()] { pthread_kill(self, SIGTERM); });
      asleep_.count_down();
      for (int signal; sigwait(&signals_, &signal) == 0 && !ended.stop_requested();) stop_.request_stop();
    });
    asleep_.wait();
  }

  std::stop_token token() const { return stop_.get_token(); }

 private:
  sigset_t signals_{};
  std::stop_source stop_;
  std::latch asleep_{1};
  std::jthread waiter_;
};

}  // namespace roadbalance
