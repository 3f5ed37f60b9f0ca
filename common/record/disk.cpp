#include "common/record/disk.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cstdio>
#include <memory>

namespace roadbalance {
namespace {

class KernelDisk final : public Disk {
 public:
  int open(const char* path, int flags, mode_t mode) override {
    const bool reads_a_file = (flags & (O_ACCMODE | O_DIRECTORY)) == O_RDONLY;
    if (!reads_a_file) return ::open(path, flags | O_CLOEXEC, mode);
    // A pipe waits for its writer, a device has no end: neither is a file or folder of a recording.
    const int file = ::open(path, flags | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, mode);
    struct stat status {};
    if (file < 0 || (::fstat(file, &status) == 0 && (S_ISREG(status.st_mode) || S_ISDIR(status.st_mode))))
      return file;
    ::close(file);
    errno = kNoRegularFile;
    return -1;
  }
  int close(int file) override { return ::close(file); }
  ssize_t write(int file, const void* bytes, std::size_t size) override { return ::write(file, bytes, size); }
  ssize_t pwrite(int file, const void* bytes, std::size_t size, off_t offset) override {
    return ::pwrite(file, bytes, size, offset);
  }
  ssize_t pread(int file, void* bytes, std::size_t size, off_t offset) override {
    return ::pread(file, bytes, size, offset);
  }
  int fdatasync(int file) override { return ::fdatasync(file); }
  int fsync(int file) override { return ::fsync(file); }
  int ftruncate(int file, off_t size) override { return ::ftruncate(file, size); }
  int fallocate(int file, int mode, off_t offset, off_t size) override {
    return ::fallocate(file, mode, offset, size);
  }
  int fadvise(int file, off_t offset, off_t size, int advice) override {
    return ::posix_fadvise(file, offset, size, advice);
  }
  off_t size(int file) override {
    struct stat status {};
    return ::fstat(file, &status) == 0 ? status.st_size : -1;
  }
  int flock(int file, int operation) override { return ::flock(file, operation); }
  int rename(const char* from, const char* to) override { return std::rename(from, to); }
  int unlink(const char* path) override { return ::unlink(path); }
  int mkdir(const char* path, mode_t mode) override { return ::mkdir(path, mode); }

  std::optional<std::vector<std::string>> list(const char* folder) override {
    const auto close_folder = [](DIR* open) { ::closedir(open); };
    const std::unique_ptr<DIR, decltype(close_folder)> open(::opendir(folder), close_folder);
    if (!open) return std::nullopt;
    std::vector<std::string> names;
    errno = 0;
    while (const dirent* entry = ::readdir(open.get())) {
      const std::string name = entry->d_name;
      if (name != "." && name != "..") names.push_back(name);
    }
    if (errno != 0) return std::nullopt;
    return names;
  }

  std::int64_t free_bytes(const char* folder) override {
    struct statvfs status {};
    if (::statvfs(folder, &status) != 0) return -1;
    return static_cast<std::int64_t>(status.f_bavail) * static_cast<std::int64_t>(status.f_frsize);
  }

  std::optional<FileIdentity> identity(const char* path) override {
    struct stat status {};
    return identity_of(::stat(path, &status), status);
  }
  std::optional<FileIdentity> identity(int file) override {
    struct stat status {};
    return identity_of(::fstat(file, &status), status);
  }

 private:
  static std::optional<FileIdentity> identity_of(int result, const struct stat& status) {
    if (result != 0) return std::nullopt;
    return FileIdentity{.device = static_cast<std::int64_t>(status.st_dev),
                        .file = static_cast<std::int64_t>(status.st_ino)};
  }
};

}  // namespace

Disk& kernel_disk() {
  static KernelDisk disk;
  return disk;
}

}  // namespace roadbalance
