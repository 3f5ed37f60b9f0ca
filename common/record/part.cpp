#include "common/record/part.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "common/record/folder.hpp"
#include "common/record/new_name.hpp"

namespace roadbalance {

namespace fs = std::filesystem;

namespace {

fs::path shell_of(const fs::path& path) {
  fs::path shell = path;
  shell += ".part";
  return shell;
}

/// Takes the folder in which something is to be made.  Another may remove it between two steps, having kept
/// what lay in it.
File take_shell(const fs::path& shell) {
  for (;;) {
    const bool is_new = fs::create_directory(shell);
    if (!fs::is_directory(shell))
      throw std::runtime_error(shell.string() + ": is in the way; remove it first");
    File folder = File::open_folder(shell);
    const auto taken = try_lock(folder);
    if (taken == false)
      throw std::runtime_error(shell.string() +
                               ": is being made by somebody else; wait, or choose another name");
    if (!taken && !is_new)
      throw std::runtime_error(shell.string() +
                               ": is left of one that was interrupted, or is being made: its disk "
                               "cannot tell which; remove it first");
    if (!fs::create_directory(shell)) return folder;
  }
}

}  // namespace

Part::Part(const fs::path& path, Kind kind) : kind_(kind), path_(fs::absolute(path).lexically_normal()) {
  const bool is_folder = kind == Kind::kFolder;
  if (is_folder && !path_.has_filename()) path_ = path_.parent_path();  // "drive/"
  const fs::path parent = path_.parent_path();
  if (!fs::is_directory(parent))
    throw std::runtime_error(parent.string() + (fs::exists(parent) ? ": is no folder" : ": no such folder"));
  if (is_folder && fs::exists(path_) && !(fs::is_directory(path_) && fs::is_empty(path_)))
    throw std::runtime_error(path_.string() + ": holds something already; allowed: a new or empty folder");
  if (!is_folder && fs::exists(path_))
    throw std::runtime_error(path_.string() + ": exists already; remove it, or choose another name");
  if (is_folder) expect_new_name(path_);
  shell_ = shell_of(path_);
  part_ = shell_ / path_.filename();
  lock_ = take_shell(shell_);
  for (const auto& entry : fs::directory_iterator(shell_))
    if (entry.path() != part_)
      throw std::runtime_error(shell_.string() + ": holds " + entry.path().filename().string() +
                               ", which is of somebody else; remove it first");
  fs::remove_all(part_);  // of one that was killed
  if (is_folder) fs::create_directory(part_);
}

Part::~Part() {
  std::error_code ignored;
  if (!lock_.is_open()) return;
  fs::remove_all(part_, ignored);
  fs::remove(shell_, ignored);
}

void Part::keep() {
  if (kind_ == Kind::kFile) File::open_to_write(part_).sync();
  if (kind_ == Kind::kFolder && fs::exists(path_)) fs::remove(path_);
  fs::rename(part_, path_);
  fs::remove(shell_);
  lock_ = File();
  sync_folder(folder_of(path_));
}

void expect_beside(const std::vector<fs::path>& sources, const fs::path& target) {
  const fs::path whole_target = fs::weakly_canonical(target);
  for (const fs::path& source : sources) {
    const fs::path whole = fs::weakly_canonical(source);
    const auto [end, ignored] =
        std::mismatch(whole.begin(), whole.end(), whole_target.begin(), whole_target.end());
    if (end == whole.end())
      throw std::runtime_error(target.string() + ": lies in " + source.string() +
                               ", which stays as it is; allowed: a place beside it");
  }
}

}  // namespace roadbalance
