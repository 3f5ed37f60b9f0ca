#include "common/record/file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

namespace roadbalance {
namespace {

[[noreturn]] void throw_errno(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

}  // namespace

File File::open(const std::filesystem::path& path, int flags) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC, 0644);
  if (descriptor < 0) throw_errno("open " + path.string());
  return {descriptor, path};
}

File File::open_to_read(const std::filesystem::path& path) {
  return open(path, O_RDONLY);
}
File File::create(const std::filesystem::path& path) {
  return open(path, O_WRONLY | O_CREAT | O_EXCL);
}
File File::open_to_write(const std::filesystem::path& path) {
  return open(path, O_WRONLY);
}
File File::open_folder(const std::filesystem::path& path) {
  return open(path, O_RDONLY | O_DIRECTORY);
}

File::File(File&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), path_(std::move(other.path_)) {}

File& File::operator=(File&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  return *this;
}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void File::fail(const char* call) const {
  throw_errno(std::string(call) + " " + path_.string());
}

std::size_t File::read_at(std::uint64_t offset, std::span<std::uint8_t> into) const {
  std::size_t done = 0;
  while (done < into.size()) {
    const ssize_t got =
        ::pread(descriptor_, into.data() + done, into.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("read");
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

void File::write_all(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("write");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void File::sync_data() {
  if (::fdatasync(descriptor_) != 0) fail("fdatasync");
}

void File::sync() {
  if (::fsync(descriptor_) != 0) fail("fsync");
}

void File::truncate(std::uint64_t size) {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) fail("truncate");
}

std::uint64_t File::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail("stat");
  return static_cast<std::uint64_t>(status.st_size);
}

void File::reserve(std::uint64_t offset, std::uint64_t bytes) noexcept {
  (void)::fallocate(descriptor_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(offset), static_cast<off_t>(bytes));
}

bool File::try_lock() {
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return true;
  if (errno != EWOULDBLOCK) fail("lock");
  return false;
}

void File::close() {
  if (descriptor_ >= 0 && ::close(std::exchange(descriptor_, -1)) != 0) fail("close");
}

void write_atomically(const std::filesystem::path& path, std::string_view text) {
  auto next = path;
  next += ".new";
  std::filesystem::remove(next);
  File file = File::create(next);
  file.write_all({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  file.sync();
  file.close();
  std::filesystem::rename(next, path);
  File::open_folder(path.parent_path().empty() ? "." : path.parent_path()).sync();
}

}  // namespace roadbalance
