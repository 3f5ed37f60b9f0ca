#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/recorder/recorder.hpp"
#include "tools/demonstration/demo_plan.hpp"

namespace roadbalance {

/// Recorder, analyser and nodes at work on one bus.  Destroying it ends them all.
class DemoTeam {
 public:
  DemoTeam() = default;
  DemoTeam(const DemoTeam&) = delete;
  DemoTeam& operator=(const DemoTeam&) = delete;
  virtual ~DemoTeam() = default;

  /// True until every node has driven to the end and the analyser has sent its last estimate.
  /// @throws std::runtime_error naming the member that failed, with its reason
  virtual bool working() = 0;

  /// "; rb-recorder: ...": the last words of each member, as far as they are known.
  virtual std::string last_words() const { return ""; }

  /// Ends the recorder in order, once no node works any more.
  /// @returns what it has of every node epoch
  virtual std::vector<NodeReport> finish() = 0;
};

/// As programs of their own, as in a car.
std::unique_ptr<DemoTeam> start_processes(const DemoPlan& plan);
/// The same functions as threads of this program.
std::unique_ptr<DemoTeam> start_threads(const DemoPlan& plan);

}  // namespace roadbalance
