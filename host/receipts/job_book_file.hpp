#pragma once

#include <filesystem>
#include <vector>

#include "host/receipts/job_book.hpp"

namespace roadbalance {

/// The book of jobs on its disk, in the folder of results.
class JobBookFile {
 public:
  explicit JobBookFile(std::filesystem::path results) : results_(std::move(results)) {}

  /// None if there is no book; if it cannot be read that is said on standard error.
  std::vector<BookedJob> read() const;

  /// By number; durable on return.  Makes the folder.
  /// @throws std::filesystem::filesystem_error, std::system_error naming the folder or file
  void write(std::vector<BookedJob> jobs) const;

 private:
  std::filesystem::path results_;
};

}  // namespace roadbalance
