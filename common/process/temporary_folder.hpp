#pragma once

#include <filesystem>
#include <string>

namespace roadbalance {

/// An empty folder of this program's own, removed with all it holds when the object goes.
class TemporaryFolder {
 public:
  /// @param name  begins the folder's name
  /// @throws std::system_error naming the folder
  explicit TemporaryFolder(const std::string& name);
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace roadbalance
