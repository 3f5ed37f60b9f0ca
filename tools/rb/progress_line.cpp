#include "tools/rb/progress_line.hpp"

#include <unistd.h>

#include <cstdio>

namespace roadbalance {

ProgressLine::~ProgressLine() {
  if (shown_) std::fputs("\n", stderr);
}

void ProgressLine::show(double part, std::uint64_t bytes) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_ || !isatty(STDERR_FILENO)) return;
  next_ = now + std::chrono::seconds(1);
  const double seconds = std::chrono::duration<double>(now - begin_).count();
  const double megabytes = 1e-6 * static_cast<double>(bytes);
  std::fprintf(stderr, "\r%5.1f %%, %.1f MB, %.1f MB/s", 100.0 * part, megabytes, megabytes / seconds);
  if (part > 0.0) std::fprintf(stderr, ", %.0f s left   ", seconds * (1.0 - part) / part);
  shown_ = true;
}

}  // namespace roadbalance
