#pragma once

#include "common/record/disk.hpp"

namespace roadbalance {

/// Another disk, for readers that need what can be read: they go around the rest.
class RescueDisk final : public Disk {
 public:
  explicit RescueDisk(Disk& disk) : disk_(disk) {}

  bool goes_around_unreadable() const override { return true; }

  int open(const char* path, int flags, mode_t mode) override { return disk_.open(path, flags, mode); }
  int close(int file) override { return disk_.close(file); }
  ssize_t write(int file, const void* bytes, std::size_t size) override {
    return disk_.write(file, bytes, size);
  }
  ssize_t pwrite(int file, const void* bytes, std::size_t size, off_t offset) override {
    return disk_.pwrite(file, bytes, size, offset);
  }
  ssize_t pread(int file, void* bytes, std::size_t size, off_t offset) override {
    return disk_.pread(file, bytes, size, offset);
  }
  int fdatasync(int file) override { return disk_.fdatasync(file); }
  int fsync(int file) override { return disk_.fsync(file); }
  int ftruncate(int file, off_t size) override { return disk_.ftruncate(file, size); }
  int fallocate(int file, int mode, off_t offset, off_t size) override {
    return disk_.fallocate(file, mode, offset, size);
  }
  int fadvise(int file, off_t offset, off_t size, int advice) override {
    return disk_.fadvise(file, offset, size, advice);
  }
  off_t size(int file) override { return disk_.size(file); }
  int flock(int file, int operation) override { return disk_.flock(file, operation); }
  int rename(const char* from, const char* to) override { return disk_.rename(from, to); }
  int unlink(const char* path) override { return disk_.unlink(path); }
  int mkdir(const char* path, mode_t mode) override { return disk_.mkdir(path, mode); }
  std::optional<std::vector<std::string>> list(const char* folder) override { return disk_.list(folder); }
  std::int64_t free_bytes(const char* folder) override { return disk_.free_bytes(folder); }
  std::optional<FileIdentity> identity(const char* path) override { return disk_.identity(path); }
  std::optional<FileIdentity> identity(int file) override { return disk_.identity(file); }

 private:
  Disk& disk_;
};

/// The machine's own, for those that only read.
inline Disk& rescue_disk() {
  static RescueDisk disk(kernel_disk());
  return disk;
}

}  // namespace roadbalance
