#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "hil_tests/players/usb_board/usb_board.hpp"

namespace roadbalance::test {

/// Front-end boards plugged into this machine's kernel: the real firmware, real enumeration, real transfers.
/// One thread is all of them.
///
/// Only where vhci_hcd is: in the guest machine, or on a node whose owner wants it; as root.
class UsbBoards {
 public:
  /// Boards, unplugged; the first drives the SYNC of the second.
  explicit UsbBoards(std::vector<Bench> benches);
  UsbBoards(const UsbBoards&) = delete;
  UsbBoards& operator=(const UsbBoards&) = delete;

  /// @throws std::runtime_error
  void plug(std::size_t which = 0);
  void unplug(std::size_t which = 0);

  UsbFaults& faults(std::size_t which = 0) { return board_[which]->faults(); }

  /// Does something with a board while its time stands still.
  void with(std::size_t which, const std::function<void(BenchBoard&)>& look);

 private:
  void run(const std::stop_token& stop);
  void serve_all(MachineTime now);

  std::mutex mutex_;  ///< whoever holds it has the boards
  std::vector<std::unique_ptr<UsbBoard>> board_;
  MachineTime served_ = MachineClock::now();  ///< they have lived until then
  std::jthread thread_;
};

}  // namespace roadbalance::test
