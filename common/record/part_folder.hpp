#pragma once

#include <filesystem>

namespace roadbalance {

/// A folder that appears under its name with all it is to hold, or not at all: until keep() it is
/// "<name>.part", and removed if it is not kept.
class PartFolder {
 public:
  /// @throws std::runtime_error if the folder holds something, or its part is there already,
  /// std::filesystem::filesystem_error if it cannot be made
  explicit PartFolder(const std::filesystem::path& path);
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;
  ~PartFolder();

  /// To write to; it is there.
  const std::filesystem::path& part() const { return part_; }
  /// All is written and synced: gives it its name.  @throws std::system_error naming it
  void keep();

 private:
  std::filesystem::path path_, part_;
  bool kept_ = false;
};

}  // namespace roadbalance
