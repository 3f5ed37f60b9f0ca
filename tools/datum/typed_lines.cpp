#include "tools/datum/typed_lines.hpp"

#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string_view>

#include "common/config/section.hpp"

namespace roadbalance {

TypedLines::TypedLines(int descriptor) : descriptor_(descriptor), terminal_(isatty(descriptor) == 1) {
  struct stat what {};
  const bool open = fstat(descriptor, &what) == 0;
  const bool can_be_read =
      open && (terminal_ || S_ISFIFO(what.st_mode) || S_ISREG(what.st_mode) || S_ISSOCK(what.st_mode));
  if (!can_be_read)
    throw ConfigError(std::string("standard input is ") +
                      (open ? "a device that nobody types at" : "closed") +
                      "; allowed: a terminal, a pipe or a file with the answers");
}

/// Lines no longer than the longest.
void TypedLines::take(const char* part, std::size_t size) {
  for (const char byte : std::string_view(part, size)) {
    const std::size_t end = read_.rfind('\n');
    const std::size_t begun = end == std::string::npos ? read_.size() : read_.size() - end - 1;
    if (byte == '\n' || begun < kLongestLine) read_ += byte;
  }
}

std::optional<std::string> TypedLines::next() {
  pollfd ready{descriptor_, POLLIN, 0};
  if (!ended_ && read_.find('\n') == std::string::npos && poll(&ready, 1, 0) > 0) {
    char part[512];
    const ssize_t size = read(descriptor_, part, sizeof part);
    if (size > 0)
      take(part, static_cast<std::size_t>(size));
    else
      ended_ = size == 0 || errno != EINTR;
  }
  const std::size_t end = read_.find('\n');
  if (end == std::string::npos && !(ended_ && !read_.empty())) return std::nullopt;
  std::string line = read_.substr(0, end);
  read_.erase(0, end == std::string::npos ? end : end + 1);
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line;
}

}  // namespace roadbalance
