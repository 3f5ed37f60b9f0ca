#pragma once

#include <string>

namespace CLI {
class App;
}

namespace roadbalance {

/// Puts a recorded drive to one of estimators() and prints what came out.
///
/// Springs, dampers and stabilisers come from the body's motion in the same drive (`chassis`), then the named
/// estimator is asked for tyres and unbalances; `chassis` itself for the former alone.
///
/// @return an ExitCode
/// @throws ConfigError if there is none of this name, or if it needs a measured road and the record has none;
///         else as collect_stretches
int identify_with(const std::string& estimator, const std::string& folder, bool refine, bool json);

/// Adds `identify --estimator NAME FOLDER` to rb-study, to which `rb identify --estimator` hands over; its
/// callback puts what identify_with() returns into `code`.
void add_identify_with(CLI::App& app, int& code);

}  // namespace roadbalance
