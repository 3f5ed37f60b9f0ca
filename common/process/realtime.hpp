#pragma once

#include <string>
#include <vector>

namespace roadbalance {

/// A thread that waits for nothing but the other comes first: acquire takes what the threads that serve a
/// device have read, and they read what the kernel's interrupt threads have.  Devices lose what is not
/// fetched in time.
inline constexpr int kAcquirePriority = 40;
inline constexpr int kDevicePriority = 45;     ///< of threads that serve a device
inline constexpr int kInterruptPriority = 50;  ///< of the kernel's interrupt threads, by its own choice

/// Asks for what a deadline needs: the calling thread ahead of all ordinary ones (SCHED_FIFO), and the
/// memory the process has by now kept in RAM (mlockall).
///
/// To be called in the thread with the deadline after everything is allocated; later allocations are not
/// locked, so that a small memory limit can refuse this call but nothing after it.
///
/// @param priority  1 .. 99
/// @return what was refused, each with the reason and where the remedy stands, for the caller to warn of;
///         empty if all was granted
[[nodiscard]] std::vector<std::string> enter_realtime(int priority);

/// The calling thread is an ordinary one again; its memory stays in RAM.
void leave_realtime();

}  // namespace roadbalance
