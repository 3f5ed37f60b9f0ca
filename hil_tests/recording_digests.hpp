#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace roadbalance::test {

/// SHA-256 of each file of a folder, by its name, as sha256sum prints them.
/// @param but  a file that does not count
/// @throws std::runtime_error if sha256sum fails
std::map<std::string, std::string> digests_of(const std::filesystem::path& folder,
                                              const std::string& but = "");

}  // namespace roadbalance::test
