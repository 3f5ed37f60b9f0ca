#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "host/analysis/drives/drive_share.hpp"

namespace CLI {
class App;
}

namespace roadbalance {

/// How the shares of many recordings are made.
struct ShareWork {
  std::size_t jobs = 1;  ///< recordings at a time, in a process
  bool refine = false;
  std::stop_token stop;
};

/// Makes the share of each recording and gives them to `take` in order: on the cores of this machine, or over
/// a cluster, where another process than the first takes none.  Called once a command, with no recordings if
/// there is nothing to share out.
using DriveSharer =
    std::function<void(const std::vector<std::filesystem::path>& recordings, const ShareWork& work,
                       const std::function<void(std::size_t which, DriveShare share)>& take)>;

/// Puts one recording to the estimator of that name, as identify_with() does.  @return an ExitCode
using EstimatorCall =
    std::function<int(const std::string& estimator, const std::string& folder, bool refine, bool json)>;

/// How a program does what `identify` is asked for.
struct IdentifyWays {
  DriveSharer sharer;
  EstimatorCall estimate;
  std::size_t jobs = 1;  ///< unless --jobs is given
  bool speaks = true;    ///< whether this process prints the result
};

/// add_identify() of command.hpp with other ways than rb's own.
void add_identify_over(CLI::App& app, int& code, const IdentifyWays& ways);

}  // namespace roadbalance
