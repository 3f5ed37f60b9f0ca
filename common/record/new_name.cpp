#include "common/record/new_name.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>

#include "common/record/folder.hpp"
#include "common/text/printable.hpp"

namespace roadbalance {
namespace {

std::string in_small_letters(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// "con", "COM1.old", "nul .txt"
bool is_device_of_windows(const std::string& name) {
  std::string stem = in_small_letters(name.substr(0, name.find('.')));
  stem.erase(stem.find_last_not_of(' ') + 1);
  constexpr std::array<std::string_view, 6> kDevices{"con", "prn", "aux", "nul", "conin$", "conout$"};
  if (std::ranges::find(kDevices, stem) != kDevices.end()) return true;
  if (!stem.starts_with("com") && !stem.starts_with("lpt")) return false;
  constexpr std::array<std::string_view, 13> kNumbers{"0", "1", "2", "3",      "4",      "5",     "6",
                                                      "7", "8", "9", "\u00B9", "\u00B2", "\u00B3"};
  return std::ranges::find(kNumbers, std::string_view(stem).substr(3)) != kNumbers.end();
}

}  // namespace

std::string fault_of_folder_name(const std::string& name) {
  if (const std::string hidden = first_hidden(name); !hidden.empty())
    return "a name has no hidden character, and this one has " + hidden;
  if (name.find_first_of("<>:\"/\\|?*") != std::string::npos) return "a name has none of / \\ : * ? \" < > |";
  if (name.empty() || name.back() == '.' || name.back() == ' ' || is_device_of_windows(name))
    return "Windows refuses this name: there none ends with a dot or a space, and con, prn, aux, nul, com1 "
           "and lpt1 "
           "are devices";
  return "";
}

std::string differs_by_capitals(const std::filesystem::path& path, Disk& disk) {
  const std::string name = name_of_folder(path);
  const std::filesystem::path folder = folder_of(path.has_filename() ? path : path.parent_path());
  if (!is_folder(folder, disk)) return "";
  for (const std::string& other : list_folder(folder, disk))
    if (other != name && in_small_letters(other) == in_small_letters(name)) return other;
  return "";
}

void expect_new_name(const std::filesystem::path& path, Disk& disk) {
  if (const std::string fault = fault_of_folder_name(name_of_folder(path)); !fault.empty())
    throw std::invalid_argument(path.string() + ": " + fault + "; choose another name");
  if (const std::string other = differs_by_capitals(path, disk); !other.empty())
    throw std::invalid_argument(path.string() + ": \"" + other +
                                "\" lies beside it and differs by capitals only; choose another name");
}

}  // namespace roadbalance
