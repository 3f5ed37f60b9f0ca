#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace roadbalance::test {

/// Gives this process and the programs it starts mounts of their own, which end with them; nothing else on
/// the computer sees them.  Returns why that is not possible here, or nothing.
std::optional<std::string> enter_private_mounts();

/// A small disk in memory at a folder, for as long as this object lives.
class MemoryDisk {
 public:
  /// @throws std::system_error naming the folder
  MemoryDisk(std::filesystem::path folder, std::uint64_t bytes);
  ~MemoryDisk();
  MemoryDisk(const MemoryDisk&) = delete;
  MemoryDisk& operator=(const MemoryDisk&) = delete;

  /// Writes a file that leaves only so much free.  @throws std::system_error
  void fill_leaving(std::uint64_t bytes);
  /// Removes that file.
  void free_again();

 private:
  std::filesystem::path filler() const { return folder_ / "filler"; }
  std::filesystem::path folder_;
};

/// A disk of its own file system (ext4 without a journal, in a file) at a folder, which turns read-only under
/// its users' feet as one does when the kernel finds it damaged.
class FailingDisk {
 public:
  /// Why this machine cannot have one; nothing if it can.
  static std::optional<std::string> refusal();

  /// @throws std::runtime_error naming the command that failed
  FailingDisk(const std::filesystem::path& image, std::filesystem::path folder, int mebibytes);
  ~FailingDisk();
  FailingDisk(const FailingDisk&) = delete;
  FailingDisk& operator=(const FailingDisk&) = delete;

  /// Every write, sync and new file fails from now on.
  void turn_read_only();
  /// Its folder is that of the disk beneath.
  void unmount();
  /// Checks it and mounts it again.
  void repair();

 private:
  void mount();
  std::string device() const;

  std::filesystem::path image_;
  std::filesystem::path folder_;
};

}  // namespace roadbalance::test
