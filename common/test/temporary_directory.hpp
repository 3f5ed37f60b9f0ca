#pragma once

#include <filesystem>
#include <string>

namespace roadbalance::test {

/// An empty directory that is removed with all it holds when the object goes.
class TemporaryDirectory {
 public:
  /// @throws std::system_error if it cannot be made
  TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  ~TemporaryDirectory();

  const std::filesystem::path& path() const { return path_; }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace roadbalance::test
