#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace roadbalance {

/// Lines that a person types, or that come through a pipe, without waiting for them.
class TypedLines {
 public:
  /// Longest line; the remainder is cut off.
  static constexpr std::size_t kLongestLine = 1000;

  /// @param descriptor  0: standard input
  /// @throws ConfigError if it is closed or no terminal, pipe or file: nobody can answer there
  explicit TypedLines(int descriptor);

  bool terminal() const { return terminal_; }
  /// The next whole line that is there, without its end.  One read at the most.
  std::optional<std::string> next();
  /// There will be no more.
  bool ended() const { return ended_ && read_.empty(); }

 private:
  const int descriptor_;
  bool terminal_ = false;
  void take(const char* part, std::size_t size);

  std::string read_;  ///< not yet given
  bool ended_ = false;
};

}  // namespace roadbalance
