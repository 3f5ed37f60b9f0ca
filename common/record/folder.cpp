#include "common/record/folder.hpp"

#include <fcntl.h>

#include <cerrno>
#include <system_error>

#include "common/record/file.hpp"

namespace roadbalance {
namespace {

bool can_open(const std::filesystem::path& path, int flags, Disk& disk) {
  int descriptor = disk.open(path.c_str(), flags, 0);
  while (descriptor < 0 && errno == EINTR) descriptor = disk.open(path.c_str(), flags, 0);
  if (descriptor >= 0) {
    disk.close(descriptor);
    return true;
  }
  if (errno == kNoRegularFile)
    throw_disk_error("open " + path.string() + ": no regular file, which is not read");
  if (errno != ENOENT && errno != ENOTDIR) throw_disk_error("open " + path.string());
  return false;
}

}  // namespace

bool path_exists(const std::filesystem::path& path, Disk& disk) {
  return can_open(path, O_RDONLY, disk);
}

bool is_folder(const std::filesystem::path& path, Disk& disk) {
  return can_open(path, O_RDONLY | O_DIRECTORY, disk);
}

std::uint64_t size_of_file(const std::filesystem::path& path, Disk& disk) {
  return File::open_to_read(path, disk).size();
}

std::string irregular_kind(const std::filesystem::path& path) {
  std::error_code is_not_there;
  switch (std::filesystem::symlink_status(path, is_not_there).type()) {
    case std::filesystem::file_type::symlink:
      return "a link";
    case std::filesystem::file_type::directory:
      return "a folder";
    case std::filesystem::file_type::fifo:
      return "a pipe";
    case std::filesystem::file_type::socket:
      return "a socket";
    case std::filesystem::file_type::character:
    case std::filesystem::file_type::block:
      return "a device";
    default:
      return "";
  }
}

std::vector<std::string> list_folder(const std::filesystem::path& path, Disk& disk) {
  auto names = disk.list(path.c_str());
  if (!names) throw_disk_error("list " + path.string());
  return std::move(*names);
}

void create_folders(const std::filesystem::path& path, Disk& disk) {
  if (path.empty() || path == path.root_path()) return;
  if (!path.has_filename()) return create_folders(path.parent_path(), disk);  // "drive/"
  create_folders(path.parent_path(), disk);
  if (!is_folder(path, disk) && disk.mkdir(path.c_str(), 0755) != 0)
    throw_disk_error("mkdir " + path.string());
  // Also for a folder that is there: the program that made it may have been killed before this.
  try {
    sync_folder(folder_of(path), disk);
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::permission_denied) throw;  // else it is not ours, and older than we are
  }
}

void sync_folder(const std::filesystem::path& path, Disk& disk) {
  File::open_folder(path, disk).sync();
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.parent_path().empty() ? std::filesystem::path(".") : path.parent_path();
}

std::string name_of_folder(const std::filesystem::path& path) {
  const auto whole = path.has_filename() ? path : path.parent_path();
  const std::string name = whole.filename().string();
  if (name != "." && name != "..") return name;
  return std::filesystem::canonical(whole).filename().string();
}

bool remove_file(const std::filesystem::path& path, Disk& disk) {
  if (disk.unlink(path.c_str()) == 0) return true;
  if (errno != ENOENT) throw_disk_error("remove " + path.string());
  return false;
}

void rename_file(const std::filesystem::path& from, const std::filesystem::path& to, Disk& disk) {
  if (disk.rename(from.c_str(), to.c_str()) != 0)
    throw_disk_error("rename " + from.string() + " to " + to.string());
}

}  // namespace roadbalance
