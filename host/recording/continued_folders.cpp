#include "host/recording/continued_folders.hpp"

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

std::vector<std::string> lines_of(const std::optional<std::string>& text) {
  std::vector<std::string> lines;
  std::istringstream all(text.value_or(""));
  for (std::string line; std::getline(all, line);) lines.push_back(line);
  return lines;
}

struct Direction {
  const char* file;  ///< lines: folders
  const char* back;  ///< the file in them that names this one
  const char* what;
};
constexpr std::array kDirections{Direction{kContinuesFile, kContinuedInFile, "what came before is in "},
                                 Direction{kContinuedInFile, kContinuesFile, "it goes on in "}};

std::vector<std::string> names_in(const std::filesystem::path& folder, const char* file, Disk& disk) {
  return lines_of(read_text(folder / file, disk));
}

/// Disks are mounted elsewhere and recordings taken along: a folder keeps its last name.
bool has_name(const std::filesystem::path& folder, const std::string& name) {
  return name_of_folder(folder) == name_of_folder(std::filesystem::path(name).lexically_normal());
}

/// Whether `other` is the folder that `folder` calls `name`: by its own name, or, if that has changed,
/// because it names `folder` in turn.
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
  const auto held = lines_of(read_whole_text(fallback / kContinuesFile, disk, Links::kRefused));
  return std::ranges::find(held, full_name(folder)) != held.end();
}

void write_continues(const std::filesystem::path& folder, const std::filesystem::path& fallback, Disk& disk) {
  if (holds_rest_of(folder, fallback, disk)) return;
  const auto file = fallback / kContinuesFile;
  write_atomically(file, read_whole_text(file, disk, Links::kRefused).value_or("") + full_name(folder) + "\n",
                   disk);
}

bool goes_on_in_fallback(const std::filesystem::path& folder, const std::filesystem::path& fallback,
                         Disk& disk) {
  const auto file = folder / kContinuedInFile;
  std::optional<std::string> text;
  try {
    text = read_whole_text(file, disk, Links::kRefused);
  } catch (const std::system_error&) {
    return false;
  }
  if (!text) return false;
  const auto lines = lines_of(text);
  const std::string where = lines.empty() ? "" : lines.front();
  if (!fallback.empty() && full_name(fallback) == where) return true;
  throw std::runtime_error("recording " + folder.string() + ": goes on in the fallback folder " + where +
                           "; name it with --fallback, or record to another folder (" + file.string() +
                           " says so)");
}

void write_continued_in(const std::filesystem::path& folder, const std::filesystem::path& fallback,
                        Disk& disk) {
  write_atomically(folder / kContinuedInFile, full_name(fallback) + "\n", disk);
}

void refuse_fallback(const std::filesystem::path& fallback, Disk& disk) {
  const auto held = lines_of(read_whole_text(fallback / kContinuesFile, disk, Links::kRefused));
  throw std::invalid_argument("fallback folder " + fallback.string() + " holds another recording" +
                              (held.empty() ? "" : ", the rest of " + held.front()) +
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
