#pragma once

#include <filesystem>
#include <vector>

#include "common/record/file.hpp"

namespace roadbalance {

/// A file or folder that appears under its name with all its content, or not at all: until keep() it lies in
/// the folder "<name>.part", and is removed if it is not kept.  The program that makes it has that folder
/// locked, so that a folder left by a killed one is recognised, and gives way.
class Part {
 public:
  enum class Kind {
    kFile,   ///< under a name that is free; whoever writes makes it
    kFolder  ///< of a recording: new, or empty so far; it is there at once
  };

  /// @throws std::runtime_error if the name is taken, another program is making it, "<name>.part" is of
  ///         another program, or the folder that it is to lie in is not there; std::invalid_argument if a
  ///         folder must not be called so (new_name.hpp); std::system_error,
  ///         std::filesystem::filesystem_error if the folder cannot be made
  Part(const std::filesystem::path& path, Kind kind);
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;
  ~Part();

  /// To write to.
  const std::filesystem::path& part() const { return part_; }
  /// The folder in which it appears.
  std::filesystem::path place() const { return path_.parent_path(); }
  /// The file is written and closed, or all in the folder is synced: gives it its name, durably.
  /// @throws std::system_error naming it
  void keep();

 private:
  const Kind kind_;
  std::filesystem::path path_;
  std::filesystem::path shell_;  ///< the folder around it
  std::filesystem::path part_;
  File lock_;  ///< of shell_
};

/// A folder that is only read stays as it is: nothing may be made in it.
/// @throws std::runtime_error naming target and source
void expect_beside(const std::vector<std::filesystem::path>& sources, const std::filesystem::path& target);

}  // namespace roadbalance
