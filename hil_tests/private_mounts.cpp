#include "hil_tests/private_mounts.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "hil_tests/program.hpp"
#include "hil_tests/throw_errno.hpp"

namespace roadbalance::test {
namespace {

constexpr double kPatience_s = 60;

void run_or_throw(const std::string& name, const std::vector<std::string>& arguments) {
  if (run(name, arguments, kPatience_s) == 0) return;
  std::string line = name;
  for (const auto& argument : arguments) line += " " + argument;
  throw std::runtime_error("failed: " + line);
}

}  // namespace

std::optional<std::string> enter_private_mounts() {
  if (::unshare(CLONE_NEWNS) != 0)
    return std::string("mounts of one's own need root: unshare: ") + std::strerror(errno);
  if (::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0)
    return std::string("mounts cannot be made private: ") + std::strerror(errno);
  return std::nullopt;
}

MemoryDisk::MemoryDisk(std::filesystem::path folder, std::uint64_t bytes) : folder_(std::move(folder)) {
  std::filesystem::create_directories(folder_);
  const std::string size = "size=" + std::to_string(bytes);
  if (::mount("tmpfs", folder_.c_str(), "tmpfs", 0, size.c_str()) != 0)
    throw_errno("mount a small disk on " + folder_.string());
}

MemoryDisk::~MemoryDisk() {
  ::umount2(folder_.c_str(), MNT_DETACH);
}

void MemoryDisk::fill_leaving(std::uint64_t bytes) {
  const std::uint64_t available = std::filesystem::space(folder_).available;
  const int file = ::open(filler().c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  if (file < 0) throw_errno("open " + filler().string());
  const int error = ::posix_fallocate(file, 0, static_cast<off_t>(available - bytes));
  ::close(file);
  if (error != 0) throw std::system_error(error, std::generic_category(), "fill " + folder_.string());
}

void MemoryDisk::free_again() {
  std::filesystem::remove(filler());
}

std::optional<std::string> FailingDisk::refusal() {
  if (::access("/dev/loop-control", R_OK | W_OK) != 0) return "there are no loop devices";
  if (!std::filesystem::exists("/sys/fs/ext4")) return "the kernel has no ext4 that can be told to fail";
  return std::nullopt;
}

FailingDisk::FailingDisk(const std::filesystem::path& image, std::filesystem::path folder, int mebibytes)
    : image_(image), folder_(std::move(folder)) {
  std::filesystem::create_directories(folder_);
  run_or_throw("truncate", {"-s", std::to_string(mebibytes) + "M", image_});
  run_or_throw("mkfs.ext4", {"-q", "-F", "-O", "^has_journal", image_});
  mount();
}

FailingDisk::~FailingDisk() {
  ::umount2(folder_.c_str(), MNT_DETACH);
}

void FailingDisk::mount() {
  run_or_throw("mount", {"-o", "loop,errors=remount-ro", image_, folder_});
}

std::string FailingDisk::device() const {
  std::ifstream mounts("/proc/self/mounts");
  for (std::string source, target, rest; mounts >> source >> target && std::getline(mounts, rest);)
    if (target == folder_) return std::filesystem::path(source).filename();
  throw std::runtime_error("not mounted: " + folder_.string());
}

void FailingDisk::turn_read_only() {
  const std::string trigger = "/sys/fs/ext4/" + device() + "/trigger_fs_error";
  std::ofstream file(trigger);
  if (!(file << "1" << std::flush)) throw std::runtime_error("cannot write " + trigger);
}

void FailingDisk::unmount() {
  if (::umount2(folder_.c_str(), MNT_DETACH) != 0) throw_errno("unmount " + folder_.string());
}

// Whoever has files open keeps the old one alive, read-only; so what it holds goes on as a copy.
void FailingDisk::repair() {
  const std::filesystem::path copy = image_.string() + ".repaired";
  run_or_throw("cp", {"--sparse=always", image_, copy});
  image_ = copy;
  const int code = run("fsck.ext4", {"-p", "-f", image_}, kPatience_s);
  if (code != 0 && code != 1) throw std::runtime_error("fsck.ext4 cannot repair " + image_.string());
  mount();
}

}  // namespace roadbalance::test
