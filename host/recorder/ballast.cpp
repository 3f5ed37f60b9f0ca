#include "host/recorder/ballast.hpp"

#include <fcntl.h>

namespace roadbalance {

Ballast::Ballast(Disk& disk, const std::filesystem::path& folder, std::int64_t bytes)
    : disk_(disk), file_(folder / "ballast"), bytes_(bytes) {}

bool Ballast::remove_old() {
  return !taken_ && disk_.unlink(file_.c_str()) == 0;
}

void Ballast::take() {
  if (taken_ || refused_ || bytes_ == 0) return;
  const int file = disk_.open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file < 0) return;
  taken_ = disk_.fallocate(file, 0, 0, bytes_) == 0;
  refused_ = !taken_;
  (void)disk_.close(file);
  if (!taken_) (void)disk_.unlink(file_.c_str());
}

bool Ballast::give_up() {
  if (!taken_) return false;
  taken_ = false;
  return disk_.unlink(file_.c_str()) == 0;
}

}  // namespace roadbalance
