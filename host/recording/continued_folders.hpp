#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/record/disk.hpp"

namespace roadbalance {

// The two folders of a record that goes on in a fallback folder: each has a file (kContinuesFile,
// kContinuedInFile of common/record/segment.hpp) with the place of the other.  The functions for recording
// throw std::system_error naming the file.

/// The one name of a folder, however it is written.
std::string full_name(const std::filesystem::path& folder);

/// The fallback names this folder among those whose rest it holds: several, if their disks failed at the
/// start.
bool holds_rest_of(const std::filesystem::path& folder, const std::filesystem::path& fallback, Disk& disk);
void write_continues(const std::filesystem::path& folder, const std::filesystem::path& fallback, Disk& disk);

/// The folder names the fallback as the place of its rest; false, too, if it cannot be read.
/// @throws std::runtime_error if it names another place: without that rest its blocks would seem missing, and
/// a gap
///         would declare them lost
bool goes_on_in_fallback(const std::filesystem::path& folder, const std::filesystem::path& fallback,
                         Disk& disk);
void write_continued_in(const std::filesystem::path& folder, const std::filesystem::path& fallback,
                        Disk& disk);

/// A fallback that a service's file names for every drive must not swallow the next one.
/// @throws std::invalid_argument always, naming the recording whose rest it holds
[[noreturn]] void refuse_fallback(const std::filesystem::path& fallback, Disk& disk);

/// Other folders that hold earlier or later parts of these, according to the files in these; for people.  A
/// folder is recognised by its last name, or because it names the other in turn.
std::vector<std::string> find_elsewhere(const std::vector<std::filesystem::path>& folders,
                                        Disk& disk = kernel_disk());

}  // namespace roadbalance
