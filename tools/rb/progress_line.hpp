#pragma once

#include <chrono>
#include <cstdint>

namespace roadbalance {

/// Progress of long work on a terminal's standard error, once a second: how much of it is done, how fast, how
/// long still.  Silent where standard error is a file.
class ProgressLine {
 public:
  ProgressLine() = default;
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine();  ///< ends the line

  /// @param part   of all work, 0 to 1
  /// @param bytes  gone through so far
  void show(double part, std::uint64_t bytes);

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point next_ = begin_ + std::chrono::seconds(1);
  bool shown_ = false;
};

}  // namespace roadbalance
