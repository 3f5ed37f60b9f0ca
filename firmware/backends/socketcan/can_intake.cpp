#include "firmware/backends/socketcan/can_intake.hpp"

#include <system_error>
#include <utility>

#include "common/process/pause.hpp"
#include "common/process/realtime.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kLongestWait{5};  // scans wait so long for what stands beside them
constexpr std::chrono::milliseconds kAskAgain{50};
constexpr int kFramesAtOnce = 1'000;

}  // namespace

CanIntake::CanIntake(const std::string& interface, CanNeed need, std::vector<CanId> wanted, Warn warn,
                     Sentence silence)
    : interface_(interface),
      need_(need),
      wanted_(std::move(wanted)),
      warn_(std::move(warn)),
      silence_(std::move(silence)),
      report_("can:" + interface),
      complete_ns_(to_ns(MachineClock::now())) {
  const std::string why = refusal(query_can_link(interface.c_str()), need, interface);
  if (!why.empty()) throw CanError(why);
  socket_.emplace(interface, wanted_);
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

CanIntake::~CanIntake() = default;

NodeTime CanIntake::complete_until() const noexcept {
  if (gone()) return as_node_time(MachineClock::now());
  return node_time_from_ns(complete_ns_.load(std::memory_order_acquire));
}

void CanIntake::run(const std::stop_token& stop) noexcept {
  for (const std::string& refused : enter_realtime(kDevicePriority)) warn_(report_.device() + ": " + refused);
  while (!stop.stop_requested()) {
    if (socket_) {
      socket_->wait(kLongestWait);
      drain();
    } else if (pause(stop, kAskAgain)) {
      find_interface();
    }
    warn_of_silence();
  }
}

/// An interface that is gone is reported otherwise.
void CanIntake::warn_of_silence() noexcept {
  if (silent_.exchange(false, std::memory_order_relaxed) && socket_) warn_(silence_());
}

void CanIntake::drain() noexcept {
  using Kind = CanReceived::Kind;
  // Frames stamped before this instant are in the socket by now: the kernel stamps and queues in one go.
  const MachineTime begun = MachineClock::now();
  for (int frame = 0; frame < kFramesAtOnce; ++frame) {
    const CanReceived received = socket_->receive();
    if (received.kind == Kind::kGone) return lose_interface();
    if (received.kind == Kind::kTrouble) report_.count(received.trouble);
    if (received.kind == Kind::kFrame) keep(received);
    if (received.kind != Kind::kNothing) continue;
    complete_ns_.store(to_ns(begun), std::memory_order_release);
    break;
  }
  count_lost();
}

void CanIntake::count_lost() noexcept {
  if (const std::uint64_t lost = socket_->take_lost(); lost > 0)
    report_.count(DeviceCounter::kQueueOverflow, static_cast<std::int64_t>(lost));
}

void CanIntake::keep(const CanReceived& received) noexcept {
  CanArrival* const place = queue_.room();
  if (!place) return report_.count(DeviceCounter::kReadersTooSlow);
  place->frame = received.frame;
  place->time = as_node_time(received.time);
  if (received.hardware_ns) place->time = hardware_->time(*received.hardware_ns, place->time);
  place->after_absence = std::exchange(after_absence_, false);
  queue_.post();
}

void CanIntake::lose_interface() noexcept {
  count_lost();
  socket_.reset();
  gone_.store(true, std::memory_order_release);
  report_.count(DeviceCounter::kGone);
}

/// Why that cannot be; empty: done.
std::string CanIntake::listen_again() {
  std::string why = refusal(query_can_link(interface_.c_str()), need_, interface_);
  if (!why.empty()) return why;
  try {
    socket_.emplace(interface_, wanted_);
  } catch (const std::system_error& error) {  // e.g. it went away in between
    why = error.what();
  }
  return why;
}

void CanIntake::find_interface() noexcept {
  const std::string why = listen_again();
  if (!why.empty()) {
    if (why_gone_.is_due(why, WallClock::now())) warn_(why);
    return;
  }
  why_gone_.over();
  hardware_.emplace();
  after_absence_ = true;
  complete_ns_.store(to_ns(MachineClock::now()), std::memory_order_release);
  gone_.store(false, std::memory_order_release);
  report_.count(DeviceCounter::kReturned);
}

}  // namespace roadbalance
