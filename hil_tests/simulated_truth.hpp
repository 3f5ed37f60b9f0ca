#pragma once

#include <filesystem>
#include <string>

namespace roadbalance::test {

/// Opens the simulated car anew and holds a record against it: each acceleration of each scan of the node,
/// and each edge of its wheels from the first scan to the last.  The node must have one epoch there,
/// complete.
/// @param drive  what the node's device was opened with, but for its rate: "seed=3&seconds=30"
void expect_as_simulated(const std::filesystem::path& record, const std::string& node,
                         const std::string& drive);

}  // namespace roadbalance::test
