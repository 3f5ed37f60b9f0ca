#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/record/disk.hpp"

namespace roadbalance {

/// Names on a disk.  Each throws std::system_error naming the call and the path unless stated otherwise.

bool path_exists(const std::filesystem::path& path, Disk& disk = kernel_disk());
bool is_folder(const std::filesystem::path& path, Disk& disk = kernel_disk());
std::uint64_t size_of_file(const std::filesystem::path& path, Disk& disk = kernel_disk());
/// What a name in a folder is if it is no regular file: "a link", "a folder", "a pipe", "a socket", "a
/// device"; empty: it is one, or is not there.  Links are not followed.  Of the machine's own disk.
std::string irregular_kind(const std::filesystem::path& path);
/// Names of a folder's entries, in no order.
std::vector<std::string> list_folder(const std::filesystem::path& path, Disk& disk = kernel_disk());

/// The folder and those above it, as far as they are missing; their names are durable on return.
void create_folders(const std::filesystem::path& path, Disk& disk = kernel_disk());
/// Makes the names in a folder durable.
void sync_folder(const std::filesystem::path& path, Disk& disk = kernel_disk());
/// The folder a path lies in: "." for a bare name.
std::filesystem::path folder_of(const std::filesystem::path& path);

/// A folder's name: "monday" of "drives/monday/", and of "." in it.
std::string name_of_folder(const std::filesystem::path& path);

/// False if there is no such file.  Durable with the folder's next sync.
bool remove_file(const std::filesystem::path& path, Disk& disk = kernel_disk());
void rename_file(const std::filesystem::path& from, const std::filesystem::path& to,
                 Disk& disk = kernel_disk());

}  // namespace roadbalance
