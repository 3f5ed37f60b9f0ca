#include "host/encoder/number_teeth.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "common/encoder/local_fit.hpp"
#include "common/encoder/tooth_tracker.hpp"
#include "host/encoder/anchor_run.hpp"

namespace roadbalance {
namespace {

/// Follows the pulses of one line; each loss of them begins a run.
class Follower {
 public:
  explicit Follower(int teeth) : tracker_(teeth), grid_{PitchTable(teeth)} {}

  void add(const Edge& edge) {
    const std::int64_t time_ns = to_ns(edge.time);
    switch (edge.kind) {
      case EdgeKind::kTooth:
        return tooth(time_ns);
      case EdgeKind::kZeroMark:
        if (tracker_.running() && !tracker_.too_long(time_ns)) run_.marks_ns.push_back(time_ns);
        return;
      case EdgeKind::kToothBackward:
      case EdgeKind::kLost:
        tracker_.forget();
        return end_run();
    }
  }
  std::vector<FollowedRun> finish() {
    end_run();
    return std::move(runs_);
  }

 private:
  void tooth(std::int64_t time_ns) {
    const auto outcome = tracker_.add(time_ns, grid_);
    switch (outcome) {
      case ToothTracker::Outcome::kStarting:
        return;
      case ToothTracker::Outcome::kStarted:
        run_.teeth.assign(tracker_.starting().begin(), tracker_.starting().end());
        return;
      case ToothTracker::Outcome::kNumbered:
        if (tracker_.missed() > 0) run_.faults_ns.push_back(time_ns);
        run_.teeth.push_back({time_ns, tracker_.number()});
        return;
      case ToothTracker::Outcome::kReplaces:
        run_.faults_ns.push_back(time_ns);
        run_.teeth.back() = {time_ns, tracker_.number()};
        return;
      case ToothTracker::Outcome::kDropped:
        run_.faults_ns.push_back(time_ns);
        return;
      case ToothTracker::Outcome::kLost:
        return end_run();
    }
  }
  void end_run() {
    if (!run_.teeth.empty()) runs_.push_back(std::move(run_));
    run_ = {};
  }

  ToothTracker tracker_;
  const ToothGrid grid_;
  FollowedRun run_;
  std::vector<FollowedRun> runs_;
};

}  // namespace

NumberedTeeth number_teeth(const EncoderConfig& config, std::span<const Edge> edges) {
  NumberedTeeth all;
  if (!config.zero_mark) return all;
  Follower follower(config.pulses_per_turn);
  for (const Edge& edge : edges) follower.add(edge);
  std::vector<FollowedRun> runs = follower.finish();

  // Where the mark lies between two teeth is the same in every run.
  std::vector<MarkChain> chains;
  std::complex<double> direction = 0.0;
  for (const FollowedRun& run : runs) {
    chains.push_back(chain_marks(run, config.pulses_per_turn));
    for (const ChainedMark& mark : chains.back().marks)
      direction += std::polar(1.0, 2.0 * std::numbers::pi * mark.position);
    all.marks_dropped += chains.back().dropped;
  }
  const double place = std::arg(direction) / (2.0 * std::numbers::pi);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (chains[i].marks.empty()) continue;
    all.runs.push_back(anchor_run(runs[i], chains[i], config.pulses_per_turn, place));
    all.slips += chains[i].slips;
    declare_faulty_turns(runs[i], chains[i], all.faulty_turns);
  }
  return all;
}

}  // namespace roadbalance
