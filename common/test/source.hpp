#pragma once

#include <string>

namespace roadbalance::test {

/// Absolute path of a file of this project, e.g. "sim/demo/vehicle.toml" or test data.
/// The root is RB_SOURCE of the environment (CTest sets it), else where the project was built from.
std::string source_path(const std::string& path_from_root);

/// The whole file.  @throws std::system_error naming it if it cannot be read
std::string read_source(const std::string& path_from_root);

}  // namespace roadbalance::test
