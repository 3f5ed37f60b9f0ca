#pragma once

#include <sys/types.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

namespace roadbalance {

/// Throws for a failed system call, naming the call and its object.
[[noreturn]] inline void throw_disk_error(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// The file that a path leads to, or a descriptor is of: st_dev and st_ino of stat.
struct FileIdentity {
  std::int64_t device = 0;
  std::int64_t file = 0;
  bool operator==(const FileIdentity&) const = default;
};

/// errno of Disk::open() for what is neither a file nor a folder: "Wrong medium type".
inline constexpr int kNoRegularFile = EMEDIUMTYPE;

/// The system calls that a record is made of, and no others.  The product uses the kernel's; tests use a disk
/// that stalls, fills up, fails at the k-th call or loses power.
///
/// Each member is the system call of its name: the result is that of the call, and errno holds why it failed.
class Disk {
 public:
  Disk() = default;
  Disk(const Disk&) = delete;
  Disk& operator=(const Disk&) = delete;
  virtual ~Disk() = default;

  virtual int open(const char* path, int flags, mode_t mode) = 0;  ///< O_CLOEXEC is added
  virtual int close(int file) = 0;
  virtual ssize_t write(int file, const void* bytes, std::size_t size) = 0;
  virtual ssize_t pwrite(int file, const void* bytes, std::size_t size, off_t offset) = 0;
  virtual ssize_t pread(int file, void* bytes, std::size_t size, off_t offset) = 0;
  virtual int fdatasync(int file) = 0;
  virtual int fsync(int file) = 0;  ///< of a folder too
  virtual int ftruncate(int file, off_t size) = 0;
  virtual int fallocate(int file, int mode, off_t offset, off_t size) = 0;
  virtual int fadvise(int file, off_t offset, off_t size, int advice) = 0;  ///< the result is the error
  virtual off_t size(int file) = 0;                                         ///< fstat; -1 on failure
  virtual int flock(int file, int operation) = 0;
  virtual int rename(const char* from, const char* to) = 0;
  virtual int unlink(const char* path) = 0;
  virtual int mkdir(const char* path, mode_t mode) = 0;

  /// Names of the entries of a folder, in no order; nothing (and errno) if it cannot be read.
  virtual std::optional<std::vector<std::string>> list(const char* folder) = 0;
  /// Bytes that an unprivileged process may still write; -1 on failure.  statvfs.
  virtual std::int64_t free_bytes(const char* folder) = 0;
  /// Nothing (and errno) on failure.  stat and fstat.
  virtual std::optional<FileIdentity> identity(const char* path) = 0;
  virtual std::optional<FileIdentity> identity(int file) = 0;

  /// Whether its readers go around bytes that cannot be read (EIO), as those do that only need what is there,
  /// or throw, as a reader that decides what is durable must.
  virtual bool goes_around_unreadable() const { return false; }
};

/// The machine's own.
Disk& kernel_disk();

}  // namespace roadbalance
