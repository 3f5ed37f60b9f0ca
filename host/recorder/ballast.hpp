#pragma once

#include <cstdint>
#include <filesystem>

#include "common/record/disk.hpp"

namespace roadbalance {

/// A file that only takes space: given up when the disk is full, so that what is under way can be closed
/// cleanly.
class Ballast {
 public:
  /// Gives up one that an earlier run left.
  Ballast(Disk& disk, const std::filesystem::path& folder, std::int64_t bytes);

  /// Takes the space if it is not taken; a disk that refuses has none for it.
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
};

}  // namespace roadbalance
