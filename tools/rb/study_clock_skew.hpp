#pragma once

namespace roadbalance {

struct ClockSkewStudyOptions {
  double seconds;
  int nodes;
  bool json;
};

/// `rb study clock-skew`: clock_skew() on a bus of its own; prints what came out or, with `json`, its object
/// on one line.  Exit code kAnswerIsNo if it is not met.
int study_clock_skew(const ClockSkewStudyOptions& options);

}  // namespace roadbalance
