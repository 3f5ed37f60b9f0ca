#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/record/disk.hpp"

namespace roadbalance {

// The two folders of a record that goes on in a fallback folder: each says in a file (kContinuesFile,
// kContinuedInFile of common/record/segment.hpp) where the other one is.  Who records throws
// std::system_error naming the file.

/// The same for every way to write it.
std::string full_name(const std::filesystem::path& folder);

/// The fallback says that it holds the rest of this folder; of several, where their disks failed at the
/// start.
bool holds_rest_of(const std::filesystem::path& folder, const std::filesystem::path& fallback, Disk& disk);
void write_continues(const std::filesystem::path& folder, const std::filesystem::path& fallback, Disk& disk);

/// The folder says that its rest is in the fallback; of one that cannot be read nothing is known.
/// @throws std::runtime_error if it says that its rest is elsewhere: without it the folder seems to lack what
///         is there, and a gap would say that it is lost
bool goes_on_in_fallback(const std::filesystem::path& folder, const std::filesystem::path& fallback,
                         Disk& disk);
void write_continued_in(const std::filesystem::path& folder, const std::filesystem::path& fallback,
                        Disk& disk);

/// A fallback that serves every drive, from a service's file, must not swallow the next one.
/// @throws std::invalid_argument always, with whose rest it holds
[[noreturn]] void refuse_fallback(const std::filesystem::path& fallback, Disk& disk);

/// Which folders that are none of these have what came before, or what comes behind, as the files in these
/// say; for people.  Folders are known by their last name, or by naming the other in turn.
std::vector<std::string> find_elsewhere(const std::vector<std::filesystem::path>& folders,
                                        Disk& disk = kernel_disk());

}  // namespace roadbalance
