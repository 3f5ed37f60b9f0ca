#include "host/recorder/continued_folders.hpp"

#include <optional>
#include <stdexcept>
#include <system_error>

#include "common/record/file.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {
namespace {

// Lines: the folders whose rest is in this one.
std::string continued_here(const std::filesystem::path& folder, Disk& disk) {
  return read_whole_text(folder / kContinuesFile, disk).value_or("");
}

bool is_line_of(const std::string& line, const std::string& text) {
  return ("\n" + text).find("\n" + line + "\n") != std::string::npos;
}

}  // namespace

std::string full_name(const std::filesystem::path& folder) {
  return std::filesystem::absolute(folder).lexically_normal().string();
}

bool holds_rest_of(const std::filesystem::path& folder, const std::filesystem::path& fallback, Disk& disk) {
  return is_line_of(full_name(folder), continued_here(fallback, disk));
}

void write_continues(const std::filesystem::path& folder, const std::filesystem::path& fallback, Disk& disk) {
  const std::string before = continued_here(fallback, disk), name = full_name(folder);
  if (is_line_of(name, before)) return;
  write_atomically(fallback / kContinuesFile, before + name + "\n", disk);
}

bool goes_on_in_fallback(const std::filesystem::path& folder, const std::filesystem::path& fallback,
                         Disk& disk) {
  const auto file = folder / kContinuedInFile;
  std::optional<std::string> where;
  try {
    where = read_whole_text(file, disk);
  } catch (const std::system_error&) {
    return false;
  }
  if (!where) return false;
  if (!fallback.empty() && full_name(fallback) + "\n" == *where) return true;
  where->erase(where->find_last_not_of('\n') + 1);
  throw std::runtime_error("recording " + folder.string() + ": goes on in the fallback folder " + *where +
                           "; name it with --fallback, or record to another folder (" + file.string() +
                           " says so)");
}

void write_continued_in(const std::filesystem::path& folder, const std::filesystem::path& fallback,
                        Disk& disk) {
  write_atomically(folder / kContinuedInFile, full_name(fallback) + "\n", disk);
}

void refuse_fallback(const std::filesystem::path& fallback, Disk& disk) {
  std::string of = continued_here(fallback, disk);
  of = of.substr(0, of.find('\n'));
  throw std::invalid_argument("fallback folder " + fallback.string() + " holds another recording" +
                              (of.empty() ? "" : ", the rest of " + of) +
                              "; move that away or name an empty folder");
}

}  // namespace roadbalance
