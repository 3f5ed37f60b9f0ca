#include "firmware/backends/usb/device_holder.hpp"

#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

bool has_open(const fs::path& process, const std::string& path) {
  std::error_code error;
  for (fs::directory_iterator file(process / "fd", error), end; !error && file != end;
       file.increment(error)) {
    std::error_code closed;  // since it was listed
    if (fs::read_symlink(file->path(), closed) == path) return true;
  }
  return false;
}

}  // namespace

std::string device_holder(const std::string& path) {
  std::string holders;
  std::error_code error;
  for (fs::directory_iterator process("/proc", error), end; !error && process != end;
       process.increment(error)) {
    const std::string id = process->path().filename();
    if (id.find_first_not_of("0123456789") != std::string::npos || !has_open(process->path(), path)) continue;
    // We have opened it, too, in order to ask.
    if (id == std::to_string(::getpid())) continue;
    std::string name;
    std::getline(std::ifstream(process->path() / "comm"), name);
    holders += (holders.empty() ? "" : ", ") + name + " (process " + id + ")";
  }
  return holders.empty() ? "this process or one that only root may look at" : holders;
}

}  // namespace roadbalance
