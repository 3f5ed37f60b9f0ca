#pragma once

#include <string>

namespace roadbalance::test {

/// Absolute path of a file of this project, e.g. "sim/demo/vehicle.toml" or test data.
/// The root is RB_SOURCE of the environment (CTest sets it), else where the project was built from.
std::string source_path(const std::string& path_from_root);

/// The whole file.  @throws std::system_error naming it if it cannot be read
std::string read_source(const std::string& path_from_root);

/// The text with every `from` as `to`.  @throws std::invalid_argument if there is none
std::string replaced(std::string text, const std::string& from, const std::string& to);

}  // namespace roadbalance::test
