#pragma once

#include <filesystem>

namespace roadbalance {

/// A file that appears under its name with all it is to hold, or not at all: until keep() it is
/// "<name>.part", and removed if it is not kept.
class PartFile {
 public:
  /// @throws std::runtime_error if the file or its part is there already
  explicit PartFile(std::filesystem::path path);
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;
  ~PartFile();

  /// To write to.
  const std::filesystem::path& part() const { return part_; }
  /// It is written and closed: syncs it and gives it its name.  @throws std::system_error naming it
  void keep();

 private:
  std::filesystem::path path_, part_;
  bool kept_ = false;
};

}  // namespace roadbalance
