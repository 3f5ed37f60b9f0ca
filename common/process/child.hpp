#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace roadbalance {

/// A program started by this one, which does not outlive it.
///
/// Its messages go to the log file, its standard output to a file beside it.  To be started by the main
/// thread: the kernel ends the child when the thread that started it ends.
class Child {
 public:
  /// How the kernel ends it when this program ends without having asked it to: asks it to end, or ends it at
  /// once, which one that is held needs: it would be held for ever.
  enum class Orphan { kIsAskedToEnd, kIsEnded };

  /// @throws std::system_error naming the program if it cannot be started
  Child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
        std::filesystem::path log, Orphan orphan = Orphan::kIsAskedToEnd);
  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;
  /// Asks it to end, after two seconds makes it.
  ~Child();

  /// Exit code once it has ended, 128 + signal if a signal ended it.
  std::optional<int> ended();
  /// Asks it to end (SIGTERM), one that is held, too.
  void stop();
  /// Ends it at once (SIGKILL).
  void end();
  /// It does nothing until it is let go on (SIGSTOP, SIGCONT).
  void hold(bool is_held);
  /// That it has read so far, of files and all else; nothing once it has ended.
  std::optional<std::int64_t> bytes_read() const;

  const std::string& name() const { return name_; }
  pid_t pid() const { return pid_; }
  /// All it has written to standard output, or the first `most` bytes of that.
  std::string output(std::size_t most = std::string::npos) const;
  /// All it has written to standard error, or the first `most` bytes of that.
  std::string log(std::size_t most = std::string::npos) const;
  /// The last line of that: why it failed.
  std::string last_words() const;
  /// Once it has ended: "was ended by signal 9", or "ended with code 4: " and its last words.
  std::string how_it_ended() const;

 private:
  std::filesystem::path output_file() const;

  std::string name_;
  std::filesystem::path log_;
  pid_t pid_ = -1;
  std::optional<int> code_;
  int signal_ = 0;  ///< that ended it, if one did
};

/// A program of ours that lies beside this one.
std::filesystem::path sibling_program(const std::string& name);

}  // namespace roadbalance
