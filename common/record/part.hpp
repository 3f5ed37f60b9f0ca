#pragma once

#include <filesystem>

namespace roadbalance {

/// A file or folder that appears under its name with all it is to hold, or not at all: until keep() it is
/// "<name>.part", and removed if it is not kept.
class Part {
 public:
  enum class Kind {
    kFile,   ///< under a name that is free; whoever writes makes the part
    kFolder  ///< new, or empty so far; its part is there at once
  };

  /// @throws std::runtime_error if the name is taken or its part is there already,
  /// std::filesystem::filesystem_error if the folder cannot be made
  Part(const std::filesystem::path& path, Kind kind);
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;
  ~Part();

  /// To write to.
  const std::filesystem::path& part() const { return part_; }
  /// The file is written and closed, or all in the folder is synced: gives it its name, durably.
  /// @throws std::system_error naming it
  void keep();

 private:
  const Kind kind_;
  std::filesystem::path path_, part_;
  bool kept_ = false;
};

}  // namespace roadbalance
