#include "host/analysis/angle/number_teeth.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <utility>

#include "common/angle/fault_balance.hpp"
#include "common/angle/local_fit.hpp"
#include "common/angle/mark_count.hpp"
#include "common/angle/own_mark.hpp"
#include "common/angle/tooth_tracker.hpp"
#include "host/analysis/angle/anchor_run.hpp"

namespace roadbalance {
namespace {

/// Finds the tooth that an earlier numbering took a pulse for.  Asked in order of time.
class EarlierNumbers {
 public:
  explicit EarlierNumbers(std::span<const NumberedRun> runs) : runs_(runs) {}

  std::optional<std::int64_t> number(std::int64_t time_ns) {
    for (; run_ < runs_.size(); ++run_, tooth_ = 0) {
      const auto& teeth = runs_[run_].teeth;
      while (tooth_ < teeth.size() && teeth[tooth_].time_ns < time_ns) ++tooth_;
      if (tooth_ == teeth.size()) continue;
      return teeth[tooth_].time_ns == time_ns ? std::optional(teeth[tooth_].number) : std::nullopt;
    }
    return std::nullopt;
  }

 private:
  const std::span<const NumberedRun> runs_;
  std::size_t run_ = 0, tooth_ = 0;
};

/// Follows the pulses of one line; each loss of them begins a run.
class Follower {
 public:
  /// @param earlier  gives where the table begins, from a tooth that it has numbered on
  Follower(const PitchTable& table, const EncoderConfig& config, std::span<const NumberedRun> earlier)
      : is_own_mark_(is_own_mark(config)),
        tracker_(config.pulses_per_turn),
        grid_{table},
        earlier_(earlier) {}

  void add(const Edge& edge) {
    const std::int64_t time_ns = to_ns(edge.time);
    switch (edge.kind) {
      case EdgeKind::kTooth:
        return tooth(time_ns);
      case EdgeKind::kZeroMark:
        if (tracker_.running() && !tracker_.too_long(time_ns)) run_.marks_ns.push_back(time_ns);
        located_again_ = false;
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
        grid_.located = located_again_ = false;
        return;
      case ToothTracker::Outcome::kNumbered:
        count_faults(time_ns, -tracker_.missed());
        run_.teeth.push_back({time_ns, tracker_.number()});
        return locate(time_ns);
      case ToothTracker::Outcome::kReplaces:
        count_faults(time_ns, 1);
        run_.teeth.back() = {time_ns, tracker_.number()};
        return;
      case ToothTracker::Outcome::kDropped:
        count_faults(time_ns, 1);
        return;
      case ToothTracker::Outcome::kLost:
        return end_run();
    }
  }
  /// Once a turn, as the earlier numbers jump where a count was put right.
  void locate(std::int64_t time_ns) {
    if (located_again_) return;
    const auto number = earlier_.number(time_ns);
    if (!number) return;
    grid_.origin = tracker_.number() - *number;
    grid_.located = located_again_ = true;
  }
  void count_faults(std::int64_t time_ns, std::int64_t surplus) {
    const auto faults = balance_.add(time_ns, tracker_.number(), surplus, tracker_.jitters());
    if (faults.count > 0) run_.faults_ns.push_back(faults.since_ns);
  }
  void end_run() {
    balance_.forget();
    if (is_own_mark_) {
      run_.marks_ns.clear();
      for (const NumberedTooth& tooth : run_.teeth) run_.marks_ns.push_back(tooth.time_ns);
    }
    if (!run_.teeth.empty()) runs_.push_back(std::move(run_));
    run_ = {};
  }

  const bool is_own_mark_;
  ToothTracker tracker_;
  ToothGrid grid_;
  EarlierNumbers earlier_;
  bool located_again_ = false;  ///< since the last mark
  FaultBalance balance_;
  FollowedRun run_;
  std::vector<FollowedRun> runs_;
};

/// Whether the marks of a drive name one tooth.
class MarkVerdict {
 public:
  explicit MarkVerdict(int teeth) : count_(teeth) {}

  void take(const MarkChain& run) {
    count_.forget();
    for (const double position : run.placed) {
      count_.add(position);
      count_.trusted() ? ++good_ : ++bad_;
      if (const auto counts = count_.counts(); counts[0] > 0) counts_ = counts;
    }
  }
  /// Most of them do.  Marks that are too few to be judged are trusted.
  bool trusted() const { return good_ >= bad_ || counts_[0] == 0; }
  std::array<int, 2> counts() const { return counts_; }

 private:
  MarkCount count_;
  std::int64_t good_ = 0, bad_ = 0;
  std::array<int, 2> counts_{};
};

}  // namespace

NumberedTeeth number_teeth(const EncoderConfig& config, std::span<const Edge> edges) {
  return number_again(config, edges, PitchTable(config.pulses_per_turn), {});
}

NumberedTeeth number_again(const EncoderConfig& config, std::span<const Edge> edges, const PitchTable& table,
                           const NumberedTeeth& earlier) {
  NumberedTeeth all;
  Follower follower(table, config, earlier.runs);
  for (const Edge& edge : edges) follower.add(edge);
  std::vector<FollowedRun> runs = follower.finish();
  if (!config.zero_mark) {
    for (FollowedRun& run : runs) all.runs.push_back({std::move(run.teeth), {}});
    return all;
  }

  // Where the mark lies between two teeth is the same in every run.
  std::vector<MarkChain> chains;
  MarkVerdict verdict(config.pulses_per_turn);
  std::complex<double> direction = 0.0;
  for (const FollowedRun& run : runs) {
    chains.push_back(chain_marks(run, config.pulses_per_turn));
    for (const ChainedMark& mark : chains.back().marks)
      direction += std::polar(1.0, 2.0 * std::numbers::pi * mark.position);
    all.marks_dropped += chains.back().dropped;
    verdict.take(chains.back());
  }
  if (!verdict.trusted()) {
    all.mark_counts = verdict.counts();
    return all;
  }
  const double place = std::arg(direction) / (2.0 * std::numbers::pi);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (chains[i].marks.empty()) continue;
    all.runs.push_back(anchor_run(runs[i], chains[i], config.pulses_per_turn, place));
    all.slips += chains[i].slips;
    declare_faulty_turns(runs[i], chains[i], all.faulty_turns);
    runs[i] = {};  // a drive's teeth are many
  }
  return all;
}

}  // namespace roadbalance
