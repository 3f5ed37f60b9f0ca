#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace roadbalance::test {

/// A program under test, started as a user would; killed with this object.
class Program {
 public:
  /// @param name  of a program in build/<preset>/bin, or one on the search path
  /// @param said  file to which its stderr is appended; empty: our stderr
  /// @throws std::system_error naming it
  Program(const std::string& name, const std::vector<std::string>& arguments,
          const std::filesystem::path& said = {});
  ~Program();
  Program(Program&& other) noexcept;
  Program& operator=(Program&& other) noexcept;
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// kill -9, and waits until it is gone.
  void kill();
  /// E.g. SIGTERM: asks it to end; SIGSTOP and SIGCONT: holds it and lets it go on.
  void signal(int number) const;
  pid_t pid() const { return pid_; }  ///< -1 once its end is known
  /// Waits for its end; nothing if it has not ended after `seconds`.  128 + signal if a signal ended it.
  std::optional<int> exit_code(double seconds);

 private:
  pid_t pid_ = -1;
};

/// Runs a program to its end.  -1 if it has not ended after `seconds`.
int run(const std::string& name, const std::vector<std::string>& arguments, double seconds);

/// True if this is the long run of the acceptance, RB_FULL=1, and not the short one of tools/check.
bool full_run();

/// Waits until `condition` holds; false if it does not within `seconds`.  A bound, not a measurement.
bool wait_until(const std::function<bool()>& condition, double seconds);

/// Folder of this build's programs.
std::filesystem::path binaries();

}  // namespace roadbalance::test
