#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/rb/finding.hpp"
#include "tools/rb/wake_up.hpp"

namespace roadbalance {

/// True if a route of the table (the text of /proc/net/route) holds LCM's group, 239.255.76.67.
bool has_multicast_route(const std::string& route_table);

Finding multicast_route(const std::string& route_table);
Finding receive_buffer(std::int64_t rmem_max_bytes);
Finding writable_folder(const std::filesystem::path& folder);
/// What to say if `folder` cannot be written to.
/// @param place  the nearest folder that exists, which takes no new file; @param error  errno of trying
Finding unwritable_folder(const std::filesystem::path& folder, const std::filesystem::path& place, int error);
/// @param limit  RLIMIT_RTPRIO of this process; @param root  whether it is root
Finding realtime_priority(std::int64_t limit, bool root);
/// Whether somebody keeps this machine's clock right, as the kernel says.
/// @param synchronised  by NTP, PTP, GPS ...
Finding wall_clock(bool synchronised);

/// What the disk of a folder has to give.
struct DiskMeasurement {
  std::uint64_t free_bytes = 0;
  std::chrono::duration<double> worst_sync{};  ///< of some writes of a block each with fdatasync
};
/// @throws std::system_error if no file can be made there
DiskMeasurement measure_disk(const std::filesystem::path& folder);
Finding disk(const std::filesystem::path& folder, const DiskMeasurement& measured);

/// How many encoder edges a second the machine took by GPIO while that was measured.
Finding encoder_edges(const WakeUpMeasurement& measured);

/// All of them on this machine.  @param wake_ups  how long those of its threads are measured
std::vector<Finding> examine_machine(const std::filesystem::path& folder, std::chrono::milliseconds wake_ups);

}  // namespace roadbalance
