#pragma once

#include <CLI/CLI.hpp>
#include <vector>

namespace roadbalance {

/// Commands of a command, in the order of --help.
inline std::vector<const CLI::App*> commands_of(const CLI::App& command) {
  return command.get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); });
}

/// What it takes with dashes and without, in the order of --help; no hidden ones.
inline std::vector<const CLI::Option*> options_of(const CLI::App& command, bool positional) {
  return command.get_options([positional](const CLI::Option* one) {
    return !one->get_group().empty() && one->get_positional() == positional;
  });
}

/// True if a word follows it.
inline bool takes_value(const CLI::Option& option) {
  return option.get_items_expected_max() > 0;
}

}  // namespace roadbalance
