#pragma once

#include <string>
#include <vector>

namespace roadbalance {

/// Asks for what a deadline needs: the calling thread ahead of all ordinary ones (SCHED_FIFO), and the
/// memory the process has by now kept in RAM (mlockall).
///
/// To be called in the thread with the deadline after everything is allocated; later allocations are not
/// locked, so that a small memory limit can refuse this call but nothing after it.
///
/// @param priority  1 .. 99
/// @return what was refused, each with the reason, for the caller to warn of; empty if all was granted
[[nodiscard]] std::vector<std::string> enter_realtime(int priority);

/// The calling thread is an ordinary one again; its memory stays in RAM.
void leave_realtime();

}  // namespace roadbalance
