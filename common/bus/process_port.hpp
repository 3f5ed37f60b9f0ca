#pragma once

#include <unistd.h>

namespace roadbalance {

/// A port for a bus of this process's own: processes side by side get different ones, nearly always; each
/// `turn` gives another.
inline int process_port(int turn = 0) {
  return 20'000 + (getpid() + 4'799 * turn) % 20'000;
}

}  // namespace roadbalance
