#include "common/record/file.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "common/record/folder.hpp"

namespace roadbalance {
namespace {

// The amount that the page cache reads at once: where a sector is bad all of it is missing.
constexpr std::uint64_t kPageBytes = 4096;

}  // namespace

File File::open(const std::filesystem::path& path, int flags, Disk& disk) {
  int descriptor = disk.open(path.c_str(), flags, 0644);
  while (descriptor < 0 && errno == EINTR) descriptor = disk.open(path.c_str(), flags, 0644);
  if (descriptor < 0 && errno == ELOOP && (flags & O_NOFOLLOW) != 0)
    throw_disk_error("open " + path.string() + ": a link, which is not followed");
  if (descriptor < 0 && errno == kNoRegularFile)
    throw_disk_error("open " + path.string() + ": no regular file, which is not read");
  if (descriptor < 0) throw_disk_error("open " + path.string());
  return {disk, descriptor, path};
}

File File::open_to_read(const std::filesystem::path& path, Disk& disk) {
  return open(path, O_RDONLY, disk);
}
File File::open_segment(const std::filesystem::path& path, Disk& disk) {
  return open(path, O_RDONLY | O_NOFOLLOW, disk);
}
File File::create(const std::filesystem::path& path, Disk& disk) {
  return open(path, O_WRONLY | O_CREAT | O_EXCL, disk);
}
File File::open_to_write(const std::filesystem::path& path, Disk& disk) {
  return open(path, O_WRONLY, disk);
}
File File::open_folder(const std::filesystem::path& path, Disk& disk) {
  return open(path, O_RDONLY | O_DIRECTORY, disk);
}

File::File(File&& other) noexcept
    : disk_(other.disk_), descriptor_(std::exchange(other.descriptor_, -1)), path_(std::move(other.path_)) {}

File& File::operator=(File&& other) noexcept {
  std::swap(disk_, other.disk_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  return *this;
}

File::~File() {
  if (descriptor_ >= 0) disk_->close(descriptor_);
}

void File::fail(const char* call) const {
  throw_disk_error(std::string(call) + " " + path_.string());
}

std::size_t File::read_at(std::uint64_t offset, std::span<std::uint8_t> into) const {
  std::size_t done = 0;
  while (done < into.size()) {
    const ssize_t got =
        disk_->pread(descriptor_, into.data() + done, into.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("read");
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

std::size_t File::read_around(std::uint64_t offset, std::span<std::uint8_t> into,
                              std::vector<Unreadable>& unreadable) const {
  try {
    return read_at(offset, into);
  } catch (const std::system_error& error) {
    if (!disk_->goes_around_unreadable() || error.code() != std::errc::io_error) throw;
  }
  const std::uint64_t end = std::min(offset + into.size(), size());
  std::uint64_t at = offset;
  while (at < end) {
    const std::uint64_t next = std::min(end, (at / kPageBytes + 1) * kPageBytes);
    const auto page = into.subspan(at - offset, next - at);
    try {
      if (const std::size_t got = read_at(at, page); got < page.size()) return at + got - offset;
    } catch (const std::system_error& error) {
      if (error.code() != std::errc::io_error) throw;
      std::ranges::fill(page, std::uint8_t{0});
      if (!unreadable.empty() && at <= unreadable.back().to)
        unreadable.back().to = std::max(next, unreadable.back().to);
      else
        unreadable.push_back({.from = at, .to = next});
    }
    at = next;
  }
  return at - offset;
}

void File::write_all(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = disk_->write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = EIO;
    if (written <= 0) fail("write");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void File::write_all_at(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written =
        disk_->pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = EIO;
    if (written <= 0) fail("write");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
}

void File::sync_data() {
  if (disk_->fdatasync(descriptor_) != 0) fail("fdatasync");
}

void File::sync() {
  if (disk_->fsync(descriptor_) != 0) fail("fsync");
}

void File::truncate(std::uint64_t size) {
  if (disk_->ftruncate(descriptor_, static_cast<off_t>(size)) != 0) fail("truncate");
}

std::uint64_t File::size() const {
  const off_t size = disk_->size(descriptor_);
  if (size < 0) fail("stat");
  return static_cast<std::uint64_t>(size);
}

void File::reserve(std::uint64_t offset, std::uint64_t bytes) noexcept {
  (void)disk_->fallocate(descriptor_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(offset),
                         static_cast<off_t>(bytes));
}

void File::read_ahead() const noexcept {
  (void)disk_->fadvise(descriptor_, 0, 0, POSIX_FADV_SEQUENTIAL);
}

void File::forget_cache() const noexcept {
  (void)disk_->fadvise(descriptor_, 0, 0, POSIX_FADV_DONTNEED);
}

bool File::is_at(const std::filesystem::path& path) const {
  const auto own = disk_->identity(descriptor_);
  if (!own) return false;  // of a disk that is gone
  const auto there = disk_->identity(path.c_str());
  if (!there && errno != ENOENT && errno != ENOTDIR)
    throw std::system_error(errno, std::generic_category(), "stat " + path.string());
  return there == own;
}

bool File::try_lock() {
  if (disk_->flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return true;
  if (errno == ENOLCK || errno == EOPNOTSUPP || errno == ENOSYS)
    throw_disk_error(
        "lock " + path_.string() +
        ": this file system has no locks; mount it with them, or choose a folder on another disk");
  if (errno != EWOULDBLOCK) fail("lock");
  return false;
}

std::optional<bool> try_lock(File& file) {
  try {
    return file.try_lock();
  } catch (const std::system_error&) {
    return std::nullopt;
  }
}

void File::close() {
  if (descriptor_ >= 0 && disk_->close(std::exchange(descriptor_, -1)) != 0) fail("close");
}

std::optional<std::string> read_text(const std::filesystem::path& path, Disk& disk, Links links) {
  if (!path_exists(path, disk)) return std::nullopt;
  const File file =
      links == Links::kFollowed ? File::open_to_read(path, disk) : File::open_segment(path, disk);
  std::string text(std::min(file.size(), kMostTextBytes), '\0');
  std::vector<File::Unreadable> unreadable;  // whose zeros no such text stands
  text.resize(file.read_around(0, {reinterpret_cast<std::uint8_t*>(text.data()), text.size()}, unreadable));
  return text;
}

std::optional<std::string> read_whole_text(const std::filesystem::path& path, Disk& disk, Links links) {
  if (path_exists(path, disk) && size_of_file(path, disk) > kMostTextBytes)
    throw std::system_error(
        EFBIG, std::generic_category(),
        "read " + path.string() + ": more than " + std::to_string(kMostTextBytes) + " bytes");
  return read_text(path, disk, links);
}

void write_atomically(const std::filesystem::path& path, std::string_view text, Disk& disk) {
  auto next = path;
  next += ".new";
  remove_file(next, disk);
  File file = File::create(next, disk);
  file.write_all({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  file.sync();
  file.close();
  rename_file(next, path, disk);
  sync_folder(folder_of(path), disk);
}

}  // namespace roadbalance
