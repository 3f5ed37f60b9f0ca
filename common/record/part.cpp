#include "common/record/part.hpp"

#include <stdexcept>
#include <system_error>

#include "common/record/file.hpp"
#include "common/record/folder.hpp"

namespace roadbalance {

namespace fs = std::filesystem;

Part::Part(const fs::path& path, Kind kind) : kind_(kind), path_(fs::absolute(path).lexically_normal()) {
  const bool is_folder = kind == Kind::kFolder;
  if (is_folder && !path_.has_filename()) path_ = path_.parent_path();  // "drive/"
  part_ = path_;
  part_ += ".part";
  if (is_folder && fs::exists(path_) && !(fs::is_directory(path_) && fs::is_empty(path_)))
    throw std::runtime_error(path_.string() + ": holds something already; allowed: a new or empty folder");
  if (!is_folder && fs::exists(path_))
    throw std::runtime_error(path_.string() + ": exists already; remove it, or choose another name");
  if (is_folder ? !fs::create_directories(part_) : fs::exists(part_))
    throw std::runtime_error(part_.string() +
                             ": is left of one that was interrupted, or is being made; remove it first");
}

Part::~Part() {
  std::error_code ignored;
  if (!kept_) fs::remove_all(part_, ignored);
}

void Part::keep() {
  if (kind_ == Kind::kFile) File::open_to_write(part_).sync();
  if (kind_ == Kind::kFolder && fs::exists(path_)) fs::remove(path_);
  fs::rename(part_, path_);
  kept_ = true;
  sync_folder(folder_of(path_));
}

}  // namespace roadbalance
