#include "host/exchange/part_file.hpp"

#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/record/file.hpp"
#include "common/record/folder.hpp"

namespace roadbalance {

PartFile::PartFile(std::filesystem::path path)
    : path_(std::filesystem::absolute(std::move(path)).lexically_normal()), part_(path_) {
  part_ += ".part";
  if (std::filesystem::exists(path_))
    throw std::runtime_error(path_.string() + ": exists already; remove it, or choose another name");
  if (std::filesystem::exists(part_))
    throw std::runtime_error(part_.string() +
                             ": is left from an export that was interrupted; remove it first");
}

PartFile::~PartFile() {
  std::error_code ignored;
  if (!kept_) std::filesystem::remove(part_, ignored);
}

void PartFile::keep() {
  File::open_to_write(part_).sync();
  std::filesystem::rename(part_, path_);
  kept_ = true;
  sync_folder(folder_of(path_));
}

}  // namespace roadbalance
