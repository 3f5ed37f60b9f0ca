#include "tools/rb/reading_progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <fstream>
#include <mutex>
#include <stop_token>
#include <string>

#include "host/recording/recordings_given.hpp"
#include "tools/rb/progress_line.hpp"

namespace roadbalance {
namespace {

std::uint64_t bytes_read() {
  std::ifstream counts("/proc/self/io");
  std::string name;
  std::uint64_t bytes = 0;
  counts >> name >> bytes;  // "rchar: 123", the first line
  return bytes;
}

void watch(const std::stop_token& stop, std::uint64_t all) {
  constexpr std::chrono::seconds kPause{1};
  const std::uint64_t before = bytes_read();
  ProgressLine line;
  std::mutex mutex;
  std::condition_variable_any pause;
  std::unique_lock lock(mutex);
  while (!pause.wait_for(lock, stop, kPause, [&] { return stop.stop_requested(); })) {
    const std::uint64_t read = bytes_read() - before;
    line.show(std::min(1.0, static_cast<double>(read) / static_cast<double>(all)), read);
  }
}

}  // namespace

ReadingProgress::ReadingProgress(const std::filesystem::path& recording, double passes) {
  // The reader of the recording reports what is wrong with it.
  if (!isatty(STDERR_FILENO) || !std::filesystem::is_directory(recording)) return;
  const auto all = static_cast<std::uint64_t>(passes * static_cast<double>(bytes_of_recording(recording)));
  if (all > 0) watch_ = std::jthread([all](const std::stop_token& stop) { watch(stop, all); });
}

}  // namespace roadbalance
