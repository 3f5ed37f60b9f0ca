#pragma once

namespace CLI {
class App;
}

namespace roadbalance {

/// As the commands of command.hpp.
void add_export(CLI::App& app, int& code);

}  // namespace roadbalance
