#include "common/test/source.hpp"

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>

namespace roadbalance::test {

std::string source_path(const std::string& path_from_root) {
  const char* root = std::getenv("RB_SOURCE");
  return std::string(root != nullptr ? root : RB_BUILT_FROM) + "/" + path_from_root;
}

std::string read_source(const std::string& path_from_root) {
  const std::string path = source_path(path_from_root);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw std::system_error(errno, std::generic_category(), "open " + path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  std::size_t place = text.find(from);
  if (place == std::string::npos) throw std::invalid_argument("there is no \"" + from + "\" in the text");
  for (; place != std::string::npos; place = text.find(from, place + to.size()))
    text.replace(place, from.size(), to);
  return text;
}

}  // namespace roadbalance::test
