#pragma once

#include <string>

namespace CLI {
class App;
}

namespace roadbalance {

/// Name of a command's page: "rb-calibrate-filter" for `rb calibrate filter`.
std::string page_name(const CLI::App& command);

/// Words that begin a command's line: "rb calibrate filter".
std::string command_path(const CLI::App& command);

/// Manual page of one command for man(1), in the macros of man(7): name, synopsis, arguments, options,
/// commands, exit status, what belongs to it.
std::string manual_page(const CLI::App& command);

}  // namespace roadbalance
