#pragma once

#include <string>

namespace CLI {
class App;
}

namespace roadbalance {

/// Completion of a program's command line for bash, to be sourced or put into its completions folder:
/// commands, options once a dash is typed, files for whatever else.
std::string bash_completion(const CLI::App& program);

}  // namespace roadbalance
