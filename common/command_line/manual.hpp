#pragma once

namespace CLI {
class App;
}

namespace roadbalance {

/// Adds the hidden option --write-manual DIR to a program that has all its commands: it writes the manual
/// page of each command (DIR/NAME-COMMAND.1) and the completion of its command line in bash (DIR/NAME.bash)
/// and ends the program as --help does.  They contain what --help prints; nothing is written twice.
///
/// @param app  named as the program is called
/// A file that cannot be written is named by the CLI::ParseError that every program reports.
void add_manual(CLI::App& app);

}  // namespace roadbalance
