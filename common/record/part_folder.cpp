#include "common/record/part_folder.hpp"

#include <stdexcept>
#include <system_error>

#include "common/record/folder.hpp"

namespace roadbalance {

namespace fs = std::filesystem;

PartFolder::PartFolder(const fs::path& path) : path_(fs::absolute(path).lexically_normal()) {
  if (!path_.has_filename()) path_ = path_.parent_path();  // "drive/"
  part_ = path_;
  part_ += ".part";
  if (fs::exists(path_) && !(fs::is_directory(path_) && fs::is_empty(path_)))
    throw std::runtime_error(path_.string() + ": holds something already; allowed: a new or empty folder");
  if (!fs::create_directory(part_))
    throw std::runtime_error(part_.string() +
                             ": is left of one that was interrupted, or is being made; remove it first");
}

PartFolder::~PartFolder() {
  std::error_code ignored;
  if (!kept_) fs::remove_all(part_, ignored);
}

void PartFolder::keep() {
  if (fs::exists(path_)) fs::remove(path_);
  fs::rename(part_, path_);
  kept_ = true;
  sync_folder(folder_of(path_));
}

}  // namespace roadbalance
