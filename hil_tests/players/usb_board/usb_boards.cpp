#include "hil_tests/players/usb_board/usb_boards.hpp"

#include <poll.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <array>

namespace roadbalance::test {
namespace {

/// Like an interrupt: before every program that reads the boards.
constexpr int kPriority = 49;
/// Conversions are caught up with so often, so that few are left to do when a packet is due.
constexpr auto kStep = std::chrono::milliseconds(1);
constexpr auto kLeastWait = std::chrono::microseconds(10);

}  // namespace

UsbBoards::UsbBoards(std::vector<Bench> benches) {
  for (std::size_t k = 0; k < benches.size(); ++k)
    board_.push_back(std::make_unique<UsbBoard>(std::move(benches[k]), static_cast<unsigned>(k)));
  if (board_.size() > 1) board_[0]->board().connect_follower(board_[1]->board());
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  const sched_param priority{kPriority};
  ::pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);
}

void UsbBoards::plug(std::size_t which) {
  const std::lock_guard lock(mutex_);
  board_[which]->power_off();
  board_[which]->port().plug();
}

void UsbBoards::unplug(std::size_t which) {
  const std::lock_guard lock(mutex_);
  board_[which]->port().unplug();
  board_[which]->power_off();
}

void UsbBoards::with(std::size_t which, const std::function<void(BenchBoard&)>& look) {
  const std::lock_guard lock(mutex_);
  look(board_[which]->board());
}

void UsbBoards::serve_all(MachineTime now) {
  // Time that passed while this thread was not scheduled is made up for in steps, between which the boards
  // send: nothing holds up their main loop.
  while (served_ < now) {
    served_ = std::min(served_ + kStep, now);
    for (auto& board : board_) board->board().advance(served_);
    for (auto& board : board_) board->serve();
  }
}

void UsbBoards::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    MachineTime until{};
    std::array<pollfd, 8> sockets{};
    {
      const std::lock_guard lock(mutex_);
      const MachineTime now = MachineClock::now();
      serve_all(now);
      until = now + kStep;
      for (std::size_t k = 0; k < board_.size(); ++k) {
        sockets[k] = {.fd = board_[k]->port().socket(), .events = POLLIN, .revents = 0};
        until = std::min(until, board_[k]->due().value_or(until));
      }
    }
    const auto patience = std::max<MachineClock::duration>(until - MachineClock::now(), kLeastWait);
    const timespec time{.tv_sec = 0, .tv_nsec = patience.count()};
    if (::ppoll(sockets.data(), board_.size(), &time, nullptr) <= 0) continue;
    const std::lock_guard lock(mutex_);
    for (std::size_t k = 0; k < board_.size(); ++k)
      if (sockets[k].revents != 0 && board_[k]->port().socket() == sockets[k].fd) board_[k]->handle();
  }
}

}  // namespace roadbalance::test
