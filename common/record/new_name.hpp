#pragma once

#include <filesystem>
#include <string>

#include "common/record/disk.hpp"

namespace roadbalance {

/// Why a recording to be made must not be called so; empty: it may.  People copy recordings to other systems,
/// which refuse names that this one takes, and read their names on screens. Source: Microsoft, Naming Files,
/// Paths, and Namespaces.
std::string fault_of_folder_name(const std::string& name);

/// What lies beside this path and differs from its name by capitals only, which other systems would take for
/// the same; empty: nothing does, or the folder it lies in is not made yet.  ASCII's letters count: file
/// systems differ about all others.
/// @throws std::system_error if the folder it lies in cannot be read
std::string differs_by_capitals(const std::filesystem::path& path, Disk& disk = kernel_disk());

/// For whoever makes the folder of a recording.
/// @throws std::invalid_argument naming path and fault; std::system_error
void expect_new_name(const std::filesystem::path& path, Disk& disk = kernel_disk());

}  // namespace roadbalance
