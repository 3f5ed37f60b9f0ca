#pragma once

#include <optional>
#include <string>

namespace roadbalance {

/// Lines that somebody types, or that come through a pipe, without waiting for them.
class TypedLines {
 public:
  /// @param descriptor  0: standard input
  /// @throws ConfigError if it is closed or no terminal, pipe or file: nobody can answer there
  explicit TypedLines(int descriptor);

  bool terminal() const { return terminal_; }
  /// The next whole line that is there, without its end.
  std::optional<std::string> next();
  /// There will be no more.
  bool ended() const { return ended_ && read_.empty(); }

 private:
  const int descriptor_;
  bool terminal_ = false;
  std::string read_;  ///< not yet given
  bool ended_ = false;
};

}  // namespace roadbalance
