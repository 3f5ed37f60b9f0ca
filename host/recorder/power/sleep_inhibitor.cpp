#include "host/recorder/power/sleep_inhibitor.hpp"

#include <fcntl.h>
#include <systemd/sd-bus.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <memory>

namespace roadbalance {
namespace {

constexpr std::uint64_t kPatience_us = 1'000'000;

/// @return the lock, or -1 and why there is none
int ask(sd_bus* bus, const char* what, std::string& refusal) {
  sd_bus_error error{};  // SD_BUS_ERROR_NULL is a literal of C
  sd_bus_message* answered = nullptr;
  int result = sd_bus_call_method(bus, "org.freedesktop.login1", "/org/freedesktop/login1",
                                  "org.freedesktop.login1.Manager", "Inhibit", &error, &answered, "ssss",
                                  what, "roadbalance", "a recording is under way", "block");
  const std::unique_ptr<sd_bus_message, decltype(&sd_bus_message_unref)> answer(answered,
                                                                                &sd_bus_message_unref);
  int lock = -1;
  if (result >= 0) result = sd_bus_message_read(answer.get(), "h", &lock);
  if (result >= 0) lock = ::fcntl(lock, F_DUPFD_CLOEXEC, 3);
  if (lock < 0) refusal = std::string("logind: ") + (error.message ? error.message : std::strerror(-result));
  sd_bus_error_free(&error);
  return lock;
}

}  // namespace

SleepInhibitor::SleepInhibitor() {
  sd_bus* opened = nullptr;
  int result = sd_bus_open_system(&opened);
  const std::unique_ptr<sd_bus, decltype(&sd_bus_flush_close_unref)> bus(opened, &sd_bus_flush_close_unref);
  if (result < 0) {
    refusal_ = std::string("no D-Bus of the system: ") + std::strerror(-result);
    return;
  }
  sd_bus_set_method_call_timeout(bus.get(), kPatience_us);
  // logind may refuse the lid to a program to which it grants the other two.
  for (const char* what : {"sleep:idle:handle-lid-switch", "sleep:idle"}) {
    lock_ = ask(bus.get(), what, refusal_);
    if (lock_ >= 0) break;
  }
  if (lock_ >= 0) refusal_.clear();
}

SleepInhibitor::~SleepInhibitor() {
  if (lock_ >= 0) ::close(lock_);
}

}  // namespace roadbalance
