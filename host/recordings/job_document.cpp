#include "host/recordings/job_document.hpp"

#include <fstream>

namespace roadbalance {

std::string begin_of(const std::filesystem::path& path) {
  std::string text(kMostRead, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

std::string shortened(std::string text) {
  static const std::string kCut = "\n... and more: rb says all of it in a terminal\n";
  if (text.size() <= kMostDocument) return text;
  const std::size_t most = kMostDocument - kCut.size();
  const std::size_t line_end = text.rfind('\n', most);
  text.resize(line_end == std::string::npos ? most : line_end);
  return text + kCut;
}

}  // namespace roadbalance
