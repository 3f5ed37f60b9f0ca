#include "tools/doctor/machine.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <numbers>
#include <thread>

#include "common/process/realtime.hpp"
#include "common/text/format.hpp"
#include "host/analysis/angle/edge_memory.hpp"

namespace roadbalance {
namespace {

constexpr const char* kRealtimeRemedy =
    "printf '%s - rtprio 50\\n%s - memlock unlimited\\n' \"$USER\" \"$USER\" | "
    "sudo tee /etc/security/limits.d/roadbalance.conf  # then log in again; the unit rb-node@ has both";

/// The kernel counts all that rb-node has mapped, heaps and stacks of its threads beside the ring:
/// 270 to 340 MB were measured with the simulated car.
constexpr std::uint64_t kMappedByANode = 512 << 20;

/// The first word of a file; empty if there is none.
std::string word_in(const std::filesystem::path& file) {
  std::string word;
  std::ifstream(file) >> word;
  return word;
}

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

Finding realtime(const RealtimeLimits& limits) {
  const bool first = limits.root || limits.priority >= kDevicePriority;
  const bool locked = limits.root || limits.locked_bytes >= kMappedByANode;
  if (first && locked)
    return {"realtime", Finding::kWell, "A node may run with real-time priority, its memory in RAM.", ""};
  const std::string in_ram = format("keep its memory in RAM (%.0f MiB may be locked)",
                                    static_cast<double>(limits.locked_bytes) / (1 << 20));
  return {"realtime", Finding::kNote,
          "A node that you start may not " + (first ? in_ram : "run with real-time priority") +
              (first || locked ? "" : ", nor " + in_ram) +
              "; its device and its ring then have to outlast a busy machine.",
          kRealtimeRemedy};
}

Finding wall_clock(bool synchronised) {
  if (synchronised) return {"clock", Finding::kWell, "This machine's clock is kept right.", ""};
  return {
      "clock", Finding::kNote,
      "Nobody keeps this machine's clock right: dates of recordings may be wrong, times within one are not.",
      "sudo timedatectl set-ntp true"};
}

// A wheel of 0.3 m at 250 km/h turns 36.8 times a second.
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

Finding encoder_edges(const WakeUpMeasurement& measured) {
  constexpr double kRing_hz = 96 * 250.0 / 3.6 / (2.0 * std::numbers::pi * 0.3);
  const double limit_hz = edge_limit_hz(measured.worst);
  const auto ms = [](auto time) { return std::chrono::duration<double, std::milli>(time).count(); };
  const std::string sentence = format(
      "Encoder edges by GPIO: in %.0f s threads%s woke up %.2f ms late at worst where the kernel takes "
      "edges one by one, %.2f ms where a node takes up to 16: up to %.1f kHz a line then; a 96-tooth "
      "ring at 250 km/h needs %.1f kHz.",
      ms(measured.duration) / 1000.0, measured.realtime ? "" : " (without real-time priority)",
      ms(measured.worst.interrupt_thread), ms(measured.worst.reader), limit_hz / 1000.0, kRing_hz / 1000.0);
  if (limit_hz >= kRing_hz) return {"encoder_edges", Finding::kWell, sentence, ""};
  return {"encoder_edges", Finding::kNote,
          sentence + "  Turns with lost edges are flagged; the USB board loses none.",
          measured.realtime
              ? "sudo apt-get install linux-image-rt-amd64  # a kernel with PREEMPT_RT; then reboot"
              : kRealtimeRemedy};
}

// Measured: 330 MB of three nodes of 16 channels, a recorder and an analyser; the page, and what a drive
// adds.
Finding memory(double available_bytes) {
  constexpr double kNeeded = 0.5e9;
  if (available_bytes >= kNeeded)
    return {"memory", Finding::kWell, format("%.1f GB of memory are free.", 1e-9 * available_bytes), ""};
  return {"memory", Finding::kNote,
          format("%.2f GB of memory are free, and the programs of a drive need up to %.2f GB: without it the "
                 "kernel ends some program.",
                 1e-9 * available_bytes, 1e-9 * kNeeded),
          "ps -eo rss,comm --sort=-rss | head  # says who has it"};
}

// "powersave" is an ordinary choice of drivers that set the frequency themselves:
// Documentation/admin-guide/pm.
std::optional<Finding> governor(const std::filesystem::path& sys) {
  const auto folder = sys / "devices/system/cpu/cpu0/cpufreq";
  const std::string driver = word_in(folder / "scaling_driver");
  if (word_in(folder / "scaling_governor") != "powersave" || driver.starts_with("intel_pstate") ||
      driver.starts_with("amd-pstate-epp") || driver.starts_with("amd_pstate_epp"))
    return std::nullopt;
  return Finding{
      "governor", Finding::kNote,
      "The processor stays at its lowest frequency: threads wake up late, and an analyser may lag.",
      "echo schedutil | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor  # for good: "
      "cpufreq.default_governor=schedutil on the kernel's command line"};
}

std::optional<Finding> battery(const std::filesystem::path& sys) {
  std::error_code error;
  for (std::filesystem::directory_iterator one(sys / "class/power_supply", error), end; !error && one != end;
       one.increment(error)) {
    const auto& folder = one->path();
    if (word_in(folder / "type") != "Battery" || word_in(folder / "scope") == "Device" ||  // a mouse's
        word_in(folder / "status") != "Discharging")
      continue;
    const std::string left = word_in(folder / "capacity");
    return Finding{"battery", Finding::kNote,
                   "This machine runs on its battery" + (left.empty() ? "" : " (" + left + " % left)") +
                       ": a desktop may send it to sleep, and a recording ends when it is empty.",
                   "systemd-inhibit --what=sleep:idle:handle-lid-switch sleep 1d  # and plug it in"};
  }
  return std::nullopt;
}

std::vector<Finding> examine_machine(std::chrono::milliseconds wake_ups) {
  const auto limit = [](auto what) -> std::uint64_t {
    rlimit of{};
    getrlimit(what, &of);
    return of.rlim_cur == RLIM_INFINITY ? kNoLimit : of.rlim_cur;
  };
  timex clock{};
  std::vector<Finding> findings{
      realtime({.priority = static_cast<std::int64_t>(std::min<std::uint64_t>(99, limit(RLIMIT_RTPRIO))),
                .locked_bytes = limit(RLIMIT_MEMLOCK),
                .root = geteuid() == 0}),
      wall_clock(adjtimex(&clock) != TIME_ERROR), encoder_edges(measure_wake_ups(wake_ups)),
      memory(available_memory())};
  for (const auto& finding : {governor(), battery()})
    if (finding) findings.push_back(*finding);
  return findings;
}

}  // namespace roadbalance
