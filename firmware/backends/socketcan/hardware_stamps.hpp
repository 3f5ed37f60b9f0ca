#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "firmware/readout_clock.hpp"

namespace roadbalance {

/// Puts the stamps of a CAN controller, whose clock runs by itself, on the machine's time line.
///
/// The kernel's own stamp is later than the controller's, unevenly so: the same as of scans that are stamped
/// when they are read, counted in nanoseconds.  Never allocates.
class HardwareStamps {
 public:
  /// @param machine  the kernel's stamp of the same frame
  NodeTime time(std::int64_t hardware_ns, NodeTime machine) noexcept {
    Scan stamp;
    stamp.index = hardware_ns;
    stamp.time = machine;
    clock_.correct(std::span(&stamp, 1));
    newest_ = std::max(newest_, stamp.time);
    return newest_;
  }

 private:
  ReadoutClock clock_{1e9};
  NodeTime newest_ = NodeTime::min();
};

}  // namespace roadbalance
