#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/frontend/registry.hpp"

namespace roadbalance {

/// Opens one node of a recording as a device: "replay:FOLDER?rate=1&node=NAME&epoch=N".
///
///   rate   seconds of the drive a wall second (default 1), or max: as fast as it is read
///   node   whose samples to take; default: the node that is opened
///   epoch  which run of it, if the recording holds several
///
/// Scans, edges and signal samples bear the times they were recorded with, scans the index; where the
/// recording has a gap the index jumps.  At any rate but 1 the device waits for its reader.  The record is
/// read ahead by a thread of its own.
///
/// @param inform  gets at the end, for a drive at a rate, by how much runs of scans were handed over late
/// @throws ConfigError naming the key of the address at fault, or a node of another rate; what RecordedDrive
///         throws
std::unique_ptr<FrontEnd> open_replay_front_end(const FrontEndRequest& request,
                                                const std::function<void(const std::string&)>& inform = {});

}  // namespace roadbalance
