#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/record/file.hpp"

namespace roadbalance {

/// Opens a file that is read more than once.
/// @throws ConfigError if it is a pipe or a device, std::system_error if it cannot be opened
std::shared_ptr<const File> open_again_and_again(const std::filesystem::path& path);

/// A place between two lines of a text.
struct LinePlace {
  std::uint64_t byte = 0;
  std::int64_t lines = 0;  ///< before it
};

/// Reads the lines of a text, and holds a part of it at a time.
class LineReader {
 public:
  explicit LineReader(std::shared_ptr<const File> file, LinePlace from = {})
      : file_(std::move(file)), held_from_(from.byte), number_(from.lines) {}
  LineReader(LineReader&&) = default;
  LineReader& operator=(LineReader&&) = default;

  /// False: there is no further line.  A carriage return at the end of a line is dropped.
  /// @throws ConfigError if a line is too long to be one, std::system_error if the file cannot be read
  bool next();
  std::string_view line() const { return line_; }
  std::int64_t number() const { return number_; }                     ///< of the line, from 1
  LinePlace place() const { return {held_from_ + begin_, number_}; }  ///< before the next one
  double part() const;  ///< of the file's bytes that lie before it

  [[noreturn]] void fail(const std::string& reason) const;  ///< ConfigError "file:line: reason"

  static constexpr std::size_t kLongestLine = 1 << 20;

 private:
  bool hold_more();

  std::shared_ptr<const File> file_;
  std::vector<char> held_;
  std::uint64_t held_from_;  ///< offset of held_
  std::size_t begin_ = 0;    ///< of the next line in held_
  std::string_view line_;
  std::int64_t number_;
};

}  // namespace roadbalance
