#pragma once

#include <cstdint>
#include <filesystem>

#include "common/record/disk.hpp"

namespace roadbalance {

/// A file that only takes space: given up when the disk is full, so that what is under way can be closed
/// cleanly.
class Ballast {
 public:
  Ballast(Disk& disk, const std::filesystem::path& folder, std::int64_t bytes);

  /// Gives up one that an earlier run left; the folder's lock is held.  False if there is none.
  bool remove_old();
  /// Takes the space if it is not taken; a disk that refuses is not asked again.
  void take();
  /// False if there was none to give up.
  bool give_up();

  bool is_taken() const { return taken_; }
  std::int64_t bytes() const { return bytes_; }

 private:
  Disk& disk_;
  const std::filesystem::path file_;
  const std::int64_t bytes_;
  bool taken_ = false;
  bool refused_ = false;
};

}  // namespace roadbalance
