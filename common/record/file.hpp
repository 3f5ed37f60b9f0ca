#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/record/disk.hpp"

namespace roadbalance {

/// An open file or directory; closes itself.  Every failed call throws std::system_error that names the call
/// and the path; an interrupted call is made again.  The disk outlives the file.
class File {
 public:
  File() = default;
  /// @throws also if it is no regular file
  static File open_to_read(const std::filesystem::path& path, Disk& disk = kernel_disk());
  /// A segment, or what else lies in the folder of a recording: a link is refused, too.
  static File open_segment(const std::filesystem::path& path, Disk& disk = kernel_disk());
  /// @throws also if it exists
  static File create(const std::filesystem::path& path, Disk& disk = kernel_disk());
  static File open_to_write(const std::filesystem::path& path, Disk& disk = kernel_disk());
  static File open_folder(const std::filesystem::path& path, Disk& disk = kernel_disk());

  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;
  ~File();

  bool is_open() const { return descriptor_ >= 0; }
  const std::filesystem::path& path() const { return path_; }

  /// As many bytes as there are at `offset`, up to the size of `into`.
  std::size_t read_at(std::uint64_t offset, std::span<std::uint8_t> into) const;
  struct Unreadable {
    std::uint64_t from = 0, to = 0;
  };
  /// The same of a disk whose readers go around what cannot be read: zeros are in its place.
  /// @param unreadable  gets where that is, in order, and joined to what lies at its end
  std::size_t read_around(std::uint64_t offset, std::span<std::uint8_t> into,
                          std::vector<Unreadable>& unreadable) const;
  void write_all(std::span<const std::uint8_t> bytes);
  void write_all_at(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  /// The data and what is needed to read it back.
  void sync_data();
  void sync();
  void truncate(std::uint64_t size);
  std::uint64_t size() const;
  /// Asks for space; the length stays as it is.  A filesystem that cannot is no error: the write will fail.
  void reserve(std::uint64_t offset, std::uint64_t bytes) noexcept;
  /// Announces to the system that this file is read from begin to end.
  void read_ahead() const noexcept;
  /// The next bytes read come from the disk, as far as they were synced.
  void forget_cache() const noexcept;
  /// Whether a path leads to this file or folder, and not to another one or nowhere, as once it was removed
  /// or its disk unmounted.
  bool is_at(const std::filesystem::path& path) const;
  /// False if another process has this file or folder locked.
  bool try_lock();
  /// Reports a failed close, which the destructor cannot.
  void close();

 private:
  File(Disk& disk, int descriptor, std::filesystem::path path)
      : disk_(&disk), descriptor_(descriptor), path_(std::move(path)) {}
  static File open(const std::filesystem::path& path, int flags, Disk& disk);
  [[noreturn]] void fail(const char* call) const;

  Disk* disk_ = nullptr;
  int descriptor_ = -1;
  std::filesystem::path path_;
};

/// As File::try_lock(); nothing: its disk has no locks.
std::optional<bool> try_lock(File& file);

/// A longer file is none of the texts beside a record.
inline constexpr std::uint64_t kMostTextBytes = std::uint64_t{16} << 20;

/// Whether a link is read as the file that it leads to.  In the folder of a recording none is: it would bring
/// foreign files in.
enum class Links { kRefused, kFollowed };

/// A small file that proves itself, as an index does; nothing if there is none.  A longer one than
/// kMostTextBytes is cut off there, which no such text stands.
std::optional<std::string> read_text(const std::filesystem::path& path, Disk& disk = kernel_disk(),
                                     Links links = Links::kRefused);
/// A small file that is needed as it is; nothing if there is none.
/// @throws std::system_error naming it, EFBIG if it is longer than kMostTextBytes
std::optional<std::string> read_whole_text(const std::filesystem::path& path, Disk& disk = kernel_disk(),
                                           Links links = Links::kFollowed);

/// Replaces `path` by a file with this text so that a reader sees the old or the new, never a part; durable
/// on return.  @throws std::system_error naming the call and the file
void write_atomically(const std::filesystem::path& path, std::string_view text, Disk& disk = kernel_disk());

}  // namespace roadbalance
