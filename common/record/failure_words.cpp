#include "common/record/failure_words.hpp"

#include <array>
#include <cerrno>
#include <filesystem>
#include <new>
#include <string_view>
#include <system_error>

#include "common/text/printable.hpp"

namespace roadbalance {
namespace {

struct Remedy {
  int code;
  std::string_view words;
};
constexpr std::array kRemedies{
    Remedy{ENOSPC, "make room on its disk, and begin again"},
    Remedy{EDQUOT, "this user's share of its disk is full: make room, and begin again"},
    Remedy{EACCES, "let the user that this program runs as read and write there"},
    Remedy{EPERM, "let the user that this program runs as read and write there"},
    Remedy{EROFS, "its disk is mounted to be read only: mount it to be written, or take another folder"},
    Remedy{EIO, "its disk fails: take another, and save what is on this one"},
    Remedy{ENODEV, "its disk is gone: plug it in, and begin again"},
    Remedy{ENOTDIR, "a file is where a folder must be: move it away, or take another folder"},
    Remedy{EEXIST, "something is there already: move it away, or take another name"},
    Remedy{EMFILE, "too many files are open: end other work of this program, and begin again"},
    Remedy{ENOMEM, "there is not enough memory: end other programs, and begin again"},
};

std::string with_remedy(std::string words, const std::error_code& code) {
  if (code.category() != std::generic_category() && code.category() != std::system_category()) return words;
  for (const Remedy& remedy : kRemedies)
    if (code.value() == remedy.code) return words.append(": ").append(remedy.words);
  return words;
}

std::string words_of(const std::exception& error) {
  if (const auto* of_file = dynamic_cast<const std::filesystem::filesystem_error*>(&error)) {
    std::string words = of_file->path1().string();
    if (!of_file->path2().empty()) words += " to " + of_file->path2().string();
    return with_remedy(words + (words.empty() ? "" : ": ") + of_file->code().message(), of_file->code());
  }
  if (const auto* of_system = dynamic_cast<const std::system_error*>(&error))
    return with_remedy(error.what(), of_system->code());
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr)
    return "there is not enough memory for it: end other programs, or take a part of it";
  return error.what();
}

}  // namespace

std::string failure_words(const std::exception& error) {
  return printable_text(words_of(error));
}

}  // namespace roadbalance
