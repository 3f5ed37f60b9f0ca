#pragma once

namespace roadbalance {

/// Exit codes of every command.
enum ExitCode : int {
  kDone = 0,
  kAnswerIsNo = 1,    ///< damaged, not identifiable, acceptance not met
  kUsage = 2,         ///< command line or configuration
  kIncomplete = 3,    ///< samples are missing, and every gap is declared
  kCannotAccess = 4,  ///< cannot read, write, start or reach something
};

}  // namespace roadbalance
