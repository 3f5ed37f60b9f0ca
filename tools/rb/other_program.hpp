#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace roadbalance {

/// The program rb-NAME that `rb NAME` runs: beside this program, else in a folder of PATH.
std::optional<std::filesystem::path> program_of_command(const std::string& name);

/// Runs it in place of this program: its exit code and signals are that program's own.
/// @throws std::runtime_error if it is not there, std::system_error if it cannot be started
[[noreturn]] void become_program(const std::string& name, const std::vector<std::string>& words);

}  // namespace roadbalance
