#include "tools/rb/other_program.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "common/process/child.hpp"

namespace roadbalance {

namespace fs = std::filesystem;

namespace {

/// A folder may have that name, and bits that let it be entered.
bool is_program(const fs::path& path) {
  std::error_code trouble;
  return fs::is_regular_file(path, trouble) && access(path.c_str(), X_OK) == 0;
}

}  // namespace

std::optional<fs::path> program_of_command(const std::string& name) {
  if (name.empty() || name.find('/') != std::string::npos) return std::nullopt;
  const std::string program = "rb-" + name;
  if (const fs::path beside = sibling_program(program); is_program(beside)) return beside;
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const fs::path there = fs::path(folder.empty() ? "." : folder) / program; is_program(there))
      return there;
  return std::nullopt;
}

void become_program(const std::string& name, const std::vector<std::string>& words) {
  const auto program = program_of_command(name);
  if (!program)
    throw std::runtime_error("rb-" + name + " is not there: neither beside rb nor in a folder of PATH");
  std::vector<std::string> all{program->string()};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> arguments;
  for (std::string& word : all) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(program->c_str(), arguments.data());
  throw std::system_error(errno, std::generic_category(), "start " + program->string());
}

}  // namespace roadbalance
