#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <vector>

#include "tools/rb/identify.hpp"

namespace roadbalance {

/// The recordings of `rb identify` dealt out in turn to all processes of MPI_COMM_WORLD, which see them at
/// the same paths.  The first process lists them and takes the shares in order; each other waits
/// with its next share until the first has asked for it: memory is bounded by the processes.
void share_on_cluster(const std::vector<std::filesystem::path>& recordings, const ShareWork& work,
                      const std::function<void(std::size_t which, DriveShare share)>& take);

}  // namespace roadbalance
