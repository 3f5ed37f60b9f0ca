#pragma once

#include <exception>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace roadbalance {

/// Adds --version to a program, which is named as it is called: "rb 0.1.0".
void add_version(CLI::App& app);

/// Adds a command that is a program of its own, `rb study` the program rb-study, to what --help, manual page
/// and completion list.  It is not called by this.
/// @return that command
CLI::App* list_program(CLI::App& app, const std::string& name, const std::string& description);

/// The command of `words`, below the command `app`.
/// @param path  by which `app` itself is called
/// @throws ConfigError naming a word that is no command, and the one that was meant
CLI::App& command_named(CLI::App& app, const std::vector<std::string>& words, const std::string& path);

/// A line on standard error with the program's name; hidden characters of files, names and keys are shown.
void report(const std::string& program, const std::string& sentence);

/// Reports why a program without commands ends.  A command line that cannot be parsed gets its help, if it
/// asks. The remedies of failure_words() are for disks: what such a program fails at may be a device or an
/// address.
/// @return an ExitCode: kUsage for a command line or configuration that cannot be used, kDone for --help, or
/// else
///         kCannotAccess
int report_failure(CLI::App& app, const std::exception& error);

/// Runs a program of commands, and reports on standard error what went wrong.
///
/// @param words  of its command line, without the program
/// @param code   set by the callback of the command, or kDone
/// @return an ExitCode: `code`; kUsage for a command line or configuration that cannot be used, kCannotAccess
/// for
///         everything else that is thrown, and if the result cannot be written to standard output
int run_program(CLI::App& app, std::vector<std::string> words, const int& code);

}  // namespace roadbalance
