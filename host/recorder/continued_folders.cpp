#include "host/recorder/continued_folders.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "common/bus/wire_text.hpp"
#include "common/record/file.hpp"
#include "common/record/folder.hpp"
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

struct Direction {
  const char* file;  ///< lines: folders
  const char* back;  ///< the file in them that names this one
  const char* what;
};
constexpr std::array kDirections{Direction{kContinuesFile, kContinuedInFile, "what came before is in "},
                                 Direction{kContinuedInFile, kContinuesFile, "it goes on in "}};

std::vector<std::string> names_in(const std::filesystem::path& folder, const char* file, Disk& disk) {
  std::vector<std::string> names;
  std::istringstream text(read_text(folder / file, disk).value_or(""));
  for (std::string line; std::getline(text, line);) names.push_back(line);
  return names;
}

/// Disks are mounted elsewhere and recordings taken along: a folder keeps its last name.
bool has_name(const std::filesystem::path& folder, const std::string& name) {
  return name_of_folder(folder) == name_of_folder(std::filesystem::path(name).lexically_normal());
}

/// That `other` is what the folder calls `name`: by its own name, or, if it has another one now, since it
/// names the folder in turn.
bool is_meant(const std::filesystem::path& other, const std::string& name,
              const std::filesystem::path& folder, const Direction& direction, Disk& disk) {
  const auto has_other = [&](const std::string& one) { return has_name(other, one); };
  const auto has_this = [&](const std::string& one) { return has_name(folder, one); };
  return has_other(name) || (std::ranges::none_of(names_in(folder, direction.file, disk), has_other) &&
                             std::ranges::any_of(names_in(other, direction.back, disk), has_this));
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

std::vector<std::string> find_elsewhere(const std::vector<std::filesystem::path>& folders, Disk& disk) {
  std::vector<std::string> lines;
  for (const Direction& direction : kDirections)
    for (const auto& folder : folders)
      for (const std::string& name : names_in(folder, direction.file, disk)) {
        const bool is_here = std::ranges::any_of(folders, [&](const auto& other) {
          return disk.identity(other.c_str()) != disk.identity(folder.c_str()) &&
                 is_meant(other, name, folder, direction, disk);
        });
        const std::string line = direction.what + wire_text::plain_text(name);
        if (!is_here && std::ranges::find(lines, line) == lines.end()) lines.push_back(line);
      }
  return lines;
}

}  // namespace roadbalance
