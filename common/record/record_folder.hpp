#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "common/record/file.hpp"

namespace roadbalance {

/// The folder of a recording that is only read: locked, so that no recorder begins to write to it meanwhile.
/// @param what_for  what waits until the recording has ended, for people: "transfer it"
/// @throws std::runtime_error naming the folder if whoever records into it has it locked
inline File hold_at_rest(const std::filesystem::path& path, const std::string& what_for,
                         Disk& disk = kernel_disk()) {
  File folder = File::open_folder(path, disk);
  if (try_lock(folder) == false)
    throw std::runtime_error(path.string() + ": is being recorded; " + what_for + " when that has ended");
  return folder;
}

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

  /// A disk that fails may be unmounted and mounted anew: files that are open of it would hinder that, and
  /// fail for ever.
  void let_go() { folder_ = File(); }

  bool is_taken() const { return folder_.is_open(); }
  /// It is taken, and what the path leads to.
  bool is_at(const std::filesystem::path& path) const { return folder_.is_open() && folder_.is_at(path); }

  /// Lets go of it if that fails.  @throws std::system_error naming the folder
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
