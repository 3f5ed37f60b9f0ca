#pragma once

#include <unistd.h>

namespace roadbalance {

/// A port for a bus of this process's own: processes side by side get different ones, nearly always; each
/// `turn` gives another.  All are below those that the kernel gives to sockets which ask for none
/// (ip_local_port_range, from 32768 on): such a socket would keep a bus from its port.
inline int process_port(int turn = 0) {
  return 12'000 + (getpid() + 4'799 * turn) % 20'000;
}

}  // namespace roadbalance
