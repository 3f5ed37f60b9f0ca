#include "common/record/test/simulated_disk.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace roadbalance::test {
namespace {

int failed(int error) {
  errno = error;
  return -1;
}

// An open file is at its place, so that no other node has its address.
FileIdentity identity_of(const SimulatedFolder::Node& node, std::int64_t device) {
  return {.device = device, .file = reinterpret_cast<std::intptr_t>(node.get())};
}

}  // namespace

SimulatedDisk::SimulatedDisk(std::uint64_t seed) : random_(seed), root_(new_folder()) {}
SimulatedDisk::~SimulatedDisk() = default;

SimulatedDisk::Fault SimulatedDisk::at_call(std::int64_t number, Outcome outcome) {
  return [number, outcome](DiskCall, std::int64_t call, const std::string&) {
    return call == number ? outcome : Outcome{};
  };
}

// False, and errno, if the call fails before it does anything.
bool SimulatedDisk::begins(DiskCall call, const std::string& path, std::size_t bytes, bool changes,
                           Outcome* outcome) {
  ++calls_;
  errno = EIO;
  if (off_) return false;
  if (cost_) busy_ += cost_(call, bytes);
  const int kills = kills_;
  const Outcome given = fault_ ? fault_(call, calls_, path) : Outcome{};
  if (outcome) *outcome = given;
  if (given.power_cut) cut_power();
  // A call in which the process is killed does nothing, nor does it fail.
  errno = off_ ? EIO : kills_ != kills ? EINTR : given.error != 0 ? given.error : EROFS;
  return kills_ == kills && given.error == 0 && !(read_only_ && changes);
}

void SimulatedDisk::kill() {
  ++kills_;
  for (const auto& [file, open] : descriptors_) forget_locks(file, open.node);
  descriptors_.clear();
}

void SimulatedDisk::cut_power() {
  kill();
  torn_sectors_ += root_->folder->lose_power(random_);
  for (auto& [path, mounted] : mounted_)
    if (mounted.root) torn_sectors_ += mounted.root->folder->lose_power(random_);
  off_ = true;
}

SimulatedDisk::Descriptor* SimulatedDisk::descriptor(int file) {
  const auto found = descriptors_.find(file);
  if (found != descriptors_.end() && !pulled_out_.contains(found->second.device)) return &found->second;
  errno = found == descriptors_.end() ? EBADF : EIO;
  return nullptr;
}

bool SimulatedDisk::has_space(const SimulatedFile& file, std::uint64_t size) const {
  return *used_bytes_ + file.space_for(size) - file.space_for(file.size()) <= capacity_bytes_;
}

int SimulatedDisk::open(const char* path, int flags, mode_t) {
  const bool writes = (flags & O_ACCMODE) != O_RDONLY;
  if (!begins(DiskCall::kOpen, path, 0, writes)) return -1;
  Place at = place(path);
  if (!at.folder) return failed(ENOENT);
  Node node = enter(at);
  if (node && (flags & O_CREAT) && (flags & O_EXCL)) return failed(EEXIST);
  if (!node && !(flags & O_CREAT)) return failed(ENOENT);
  if (node && !node->folder && (flags & O_DIRECTORY)) return failed(ENOTDIR);
  if (node && node->folder && writes) return failed(EISDIR);
  if (!node) {
    node = std::make_shared<SimulatedNode>();
    node->file = std::make_unique<SimulatedFile>(used_bytes_);
    at.folder->add(at.name, node);
  } else if (node->file && (flags & O_TRUNC)) {
    node->file->resize(0);
  }
  descriptors_.emplace(next_descriptor_, Descriptor{.node = std::move(node),
                                                    .path = path,
                                                    .device = at.device,
                                                    .writes = writes,
                                                    .appends = (flags & O_APPEND) != 0});
  return next_descriptor_++;
}

void SimulatedDisk::forget_locks(int file, const Node& node) {
  if (node->locked_by == file) node->locked_by = -1;
}

// As on Linux the descriptor is gone though the call fails.
int SimulatedDisk::close(int file) {
  const auto open = descriptors_.find(file);
  if (open == descriptors_.end()) return failed(EBADF);
  const bool good = begins(DiskCall::kClose, open->second.path, 0, false);
  const int error = errno;
  if (descriptors_.contains(file)) forget_locks(file, open->second.node);
  descriptors_.erase(file);
  return good ? 0 : failed(error);
}

ssize_t SimulatedDisk::write(int file, const void* bytes, std::size_t size) {
  Descriptor* open = descriptor(file);
  if (!open) return -1;
  if (open->appends && open->node->file) open->offset = open->node->file->size();
  const ssize_t written = pwrite(file, bytes, size, static_cast<off_t>(open->offset));
  if (written > 0) open->offset += static_cast<std::uint64_t>(written);
  return written;
}

ssize_t SimulatedDisk::pwrite(int file, const void* bytes, std::size_t size, off_t at) {
  Descriptor* open = descriptor(file);
  if (!open) return -1;
  Outcome outcome;
  if (!begins(DiskCall::kWrite, open->path, size, true, &outcome)) return -1;
  if (!open->writes || !open->node->file) return failed(EBADF);
  SimulatedFile& content = *open->node->file;
  const auto offset = static_cast<std::uint64_t>(at);
  if (outcome.short_write) size = std::max<std::size_t>(size / 2, 1);
  if (offset + size > content.size() && !has_space(content, offset + size)) {
    const std::int64_t room =
        capacity_bytes_ - *used_bytes_ + content.space_for(content.size()) - static_cast<std::int64_t>(at);
    if (room <= 0) return failed(ENOSPC);
    size = std::min(size, static_cast<std::size_t>(room));
    if (!has_space(content, offset + size)) return failed(ENOSPC);
  }
  content.write(offset, {static_cast<const std::uint8_t*>(bytes), size});
  return static_cast<ssize_t>(size);
}

ssize_t SimulatedDisk::pread(int file, void* bytes, std::size_t size, off_t offset) {
  Descriptor* open = descriptor(file);
  if (!open || !begins(DiskCall::kRead, open->path, size, false)) return -1;
  if (!open->node->file) return failed(EISDIR);
  const auto from = static_cast<std::uint64_t>(offset);
  for (const auto& [path, byte] : spoilt_) {
    const std::uint64_t sector = byte / SimulatedFile::kSectorBytes * SimulatedFile::kSectorBytes;
    if (path == open->path && sector < from + size && from < sector + SimulatedFile::kSectorBytes)
      return failed(EIO);
  }
  if (from >= open->node->file->size()) return 0;
  return static_cast<ssize_t>(open->node->file->read(from, {static_cast<std::uint8_t*>(bytes), size}));
}

int SimulatedDisk::sync(DiskCall call, int file) {
  Descriptor* open = descriptor(file);
  if (!open) return -1;
  const Node node = open->node;
  if (!begins(call, open->path, 0, false)) {
    const int error = errno;
    if (node->file && !off_ && error != EINTR) node->file->fail_sync(random_);
    return failed(error);
  }
  if (node->file) node->file->sync();
  if (node->folder) node->folder->sync();
  return 0;
}

int SimulatedDisk::ftruncate(int file, off_t size) {
  Descriptor* open = descriptor(file);
  if (!open || !begins(DiskCall::kTruncate, open->path, 0, true)) return -1;
  if (!open->writes || !open->node->file) return failed(EINVAL);
  if (!has_space(*open->node->file, static_cast<std::uint64_t>(size))) return failed(ENOSPC);
  open->node->file->resize(static_cast<std::uint64_t>(size));
  return 0;
}

int SimulatedDisk::fallocate(int file, int mode, off_t offset, off_t size) {
  Descriptor* open = descriptor(file);
  if (!open || !begins(DiskCall::kReserve, open->path, 0, true)) return -1;
  if (!open->writes || !open->node->file) return failed(EBADF);
  if ((mode & ~FALLOC_FL_KEEP_SIZE) != 0) return failed(EOPNOTSUPP);
  SimulatedFile& content = *open->node->file;
  const auto end = static_cast<std::uint64_t>(offset + size);
  if (!has_space(content, end)) return failed(ENOSPC);
  if ((mode & FALLOC_FL_KEEP_SIZE) == 0 && end > content.size()) content.resize(end);
  content.reserve(end);
  return 0;
}

off_t SimulatedDisk::size(int file) {
  Descriptor* open = descriptor(file);
  if (!open || !begins(DiskCall::kSize, open->path, 0, false)) return -1;
  return open->node->file ? static_cast<off_t>(open->node->file->size()) : 0;
}

int SimulatedDisk::flock(int file, int operation) {
  Descriptor* open = descriptor(file);
  if (!open || !begins(DiskCall::kLock, open->path, 0, false)) return -1;
  int& owner = open->node->locked_by;
  if (operation & LOCK_UN) {
    forget_locks(file, open->node);
    return 0;
  }
  if (owner >= 0 && owner != file) return failed(EWOULDBLOCK);
  owner = file;
  return 0;
}

int SimulatedDisk::rename(const char* from, const char* to) {
  if (!begins(DiskCall::kRename, from, 0, true)) return -1;
  const Place source = place(from);
  const Place target = place(to);
  if (!source.folder || !target.folder || source.name.empty() || target.name.empty()) return failed(ENOENT);
  if (!source.folder->find(source.name)) return failed(ENOENT);
  if (source.folder != target.folder) return failed(EXDEV);
  if (source.name != target.name) source.folder->rename(source.name, target.name);
  return 0;
}

int SimulatedDisk::unlink(const char* path) {
  if (!begins(DiskCall::kUnlink, path, 0, true)) return -1;
  const Node node = find(path);
  if (!node) return failed(ENOENT);
  if (node->folder) return failed(EISDIR);
  const Place at = place(path);
  at.folder->remove(at.name);
  return 0;
}

int SimulatedDisk::mkdir(const char* path, mode_t) {
  if (!begins(DiskCall::kMakeFolder, path, 0, true)) return -1;
  const Place at = place(path);
  if (!at.folder) return failed(ENOENT);
  if (find(path)) return failed(EEXIST);
  at.folder->add(at.name, new_folder());
  return 0;
}

std::optional<std::vector<std::string>> SimulatedDisk::list(const char* folder) {
  if (!begins(DiskCall::kList, folder, 0, false)) return std::nullopt;
  const Node node = find(folder);
  if (!node || !node->folder) {
    errno = node ? ENOTDIR : ENOENT;
    return std::nullopt;
  }
  std::vector<std::string> names;
  for (const auto& [name, entry] : node->folder->entries()) names.push_back(name);
  return names;
}

std::int64_t SimulatedDisk::free_bytes(const char* folder) {
  if (!begins(DiskCall::kFreeBytes, folder, 0, false)) return -1;
  return std::max<std::int64_t>(capacity_bytes_ - *used_bytes_, 0);
}

std::optional<FileIdentity> SimulatedDisk::identity(const char* path) {
  if (!begins(DiskCall::kIdentity, path, 0, false)) return std::nullopt;
  Place at = place(path);
  if (const Node node = at.folder ? enter(at) : nullptr) return identity_of(node, at.device);
  errno = ENOENT;
  return std::nullopt;
}

std::optional<FileIdentity> SimulatedDisk::identity(int file) {
  const Descriptor* open = descriptor(file);
  if (!open || !begins(DiskCall::kIdentity, open->path, 0, false)) return std::nullopt;
  return identity_of(open->node, open->device);
}

// The node at a place; the place's device becomes that of what is mounted there.
SimulatedDisk::Node SimulatedDisk::enter(Place& at) const {
  const auto mounted = mounted_.find(at.path);
  if (mounted == mounted_.end() || !mounted->second.is_there)
    return at.name.empty() ? root_ : at.folder->find(at.name);
  at.device = mounted->second.device;
  return mounted->second.root;
}

void SimulatedDisk::mount(const std::string& folder) {
  Mounted& mounted = mounted_[folder];
  if (!mounted.root) {
    mounted.device = ++last_device_;
    mounted.root = new_folder();
  }
  mounted.is_there = true;
}

void SimulatedDisk::plug_in(const std::string& folder) {
  Mounted& mounted = mounted_.at(folder);
  mounted = {.root = copy_of(*mounted.root, used_bytes_), .device = ++last_device_, .is_there = true};
}

void SimulatedDisk::replace(const std::string& folder) {
  Mounted& mounted = mounted_.at(folder);
  for (const auto& [file, open] : descriptors_)
    if (open.device == mounted.device) return plug_in(folder);
  pulled_out_.erase(mounted.device);
  mounted.root = new_folder();
  mounted.is_there = true;
}

void SimulatedDisk::pull_out(const std::string& folder) {
  Mounted& mounted = mounted_.at(folder);
  mounted.root->folder->lose_power(random_);
  mounted.is_there = false;
  pulled_out_.insert(mounted.device);
}

SimulatedDisk::Place SimulatedDisk::place(const std::string& path) const {
  Place result{.folder = root_->folder.get(), .name = {}, .path = {}};
  std::size_t at = 0;
  while (at < path.size()) {
    const std::size_t end = std::min(path.find('/', at), path.size());
    const std::string part = path.substr(at, end - at);
    at = end + 1;
    if (part.empty() || part == ".") continue;
    if (!result.name.empty()) {
      const Node inner = enter(result);
      if (!inner || !inner->folder) return {};
      result.folder = inner->folder.get();
    }
    result.name = part;
    result.path += "/" + part;
  }
  return result;
}

SimulatedDisk::Node SimulatedDisk::find(const std::string& path) const {
  Place at = place(path);
  return at.folder ? enter(at) : nullptr;
}

std::vector<std::uint8_t> SimulatedDisk::content(const std::string& path) const {
  const Node node = find(path);
  if (!node || !node->file) return {};
  std::vector<std::uint8_t> bytes(node->file->size());
  node->file->read(0, bytes);
  return bytes;
}

void SimulatedDisk::put(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  const Place at = place(path);
  auto node = std::make_shared<SimulatedNode>();
  node->file = std::make_unique<SimulatedFile>(used_bytes_);
  node->file->write(0, bytes);
  node->file->sync();
  at.folder->add(at.name, std::move(node));
  at.folder->sync();
}

void SimulatedDisk::flip_bit(const std::string& path, std::uint64_t bit) {
  find(path)->file->damage(bit / 8, static_cast<std::uint8_t>(1u << bit % 8));
}

}  // namespace roadbalance::test
