#include "common/config/text_file.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

namespace roadbalance {

// A stream of the C++ library would open a folder and would not keep the reason of a failure.
std::string read_text_file(const std::string& path, std::size_t most) {
  const auto fail = [&path] { throw std::system_error(errno, std::generic_category(), "read " + path); };
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
  if (!file) fail();
  std::string text;
  std::array<char, 65'536> part;
  while (text.size() <= most) {
    const std::size_t size = std::fread(part.data(), 1, part.size(), file.get());
    if (size == 0) break;
    text.append(part.data(), size);
  }
  if (std::ferror(file.get())) fail();
  return text;
}

}  // namespace roadbalance
