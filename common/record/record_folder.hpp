#pragma once

#include <cerrno>
#include <system_error>
#include <utility>

#include "common/record/file.hpp"

namespace roadbalance {

/// The folder of a recording in the hands of its only writer: locked against others, synced when names in it
/// have changed.
class RecordFolder {
 public:
  /// Opens and locks it.  @return false if another program writes to it
  bool take(const std::filesystem::path& path, Disk& disk) {
    folder_ = File::open_folder(path, disk);
    if (folder_.try_lock()) return true;
    folder_ = File();
    return false;
  }

  /// Takes it again if a sync has failed since.  @throws std::system_error naming the folder
  void take_again(const std::filesystem::path& path, Disk& disk) {
    if (!folder_.is_open() && !take(path, disk))
      throw std::system_error(EBUSY, std::generic_category(), "recording " + path.string());
  }

  /// A disk that fails may be mounted anew: what is open of the old one would fail for ever, so it is given
  /// up.
  /// @throws std::system_error naming the folder
  void sync() {
    File taken = std::exchange(folder_, File());
    taken.sync();
    folder_ = std::move(taken);
  }

  File& file() { return folder_; }

 private:
  File folder_;
};

}  // namespace roadbalance
