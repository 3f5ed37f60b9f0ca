#include "host/analysis/angle/anchor_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "common/angle/local_fit.hpp"
#include "common/angle/mark_scatter.hpp"

namespace roadbalance {
namespace {

constexpr std::ptrdiff_t kTeethBeside = 8;  // each side of a mark, to place it
constexpr double kGate_pitches = 0.42;

/// Position of an instant by the count of teeth around it; nothing where there are too few.
std::optional<double> position_of(const FollowedRun& run, std::int64_t time_ns) {
  const auto here = std::ranges::lower_bound(run.teeth, time_ns, {}, &NumberedTooth::time_ns);
  const auto from = here - std::min(kTeethBeside, here - run.teeth.begin());
  const auto to = here + std::min(kTeethBeside, run.teeth.end() - here);
  if (here == run.teeth.begin() || here == run.teeth.end()) return std::nullopt;
  WheelPath path(static_cast<std::size_t>(2 * kTeethBeside));
  for (auto tooth = from; tooth != to; ++tooth)
    path.push({tooth->time_ns, static_cast<double>(tooth->number - from->number), 1.0});
  LocalFit local;
  if (!local.fit(path, 0, path.size(), 0.0)) return std::nullopt;
  return local.position(static_cast<double>(time_ns - from->time_ns)) + static_cast<double>(from->number);
}

/// Where marks are expected: the mean of those before, so that the jitter of one does not count twice.
class Expected {
 public:
  explicit Expected(int teeth) : teeth_(teeth) {}

  void begin(const ChainedMark& mark) {
    position_ = mark.position;
    marks_ = 0;
  }
  /// Turns from the beginning, and how many teeth the mark is off.
  std::pair<std::int64_t, double> place(const ChainedMark& mark) const {
    const double way = mark.position - position_;
    const std::int64_t turn = std::llround(way / teeth_);
    return {turn, way - static_cast<double>(turn) * teeth_};
  }
  /// The count of teeth has slipped by so many from the first of these marks on, as the next ones show, too.
  bool slipped(std::span<const ChainedMark> marks, std::int64_t slip) const {
    double evidence = 0.0;
    std::int64_t last_turn = std::numeric_limits<std::int64_t>::min();
    for (const ChainedMark& mark : marks) {
      const auto [turn, off] = place(mark);
      if (turn <= last_turn || !MarkScatter::speaks_of(off, slip)) continue;
      last_turn = turn;
      evidence += scatter_.evidence_of_one(off, slip);
      if (evidence > MarkScatter::kSure) return true;
      if (evidence <= 0.0) return false;
    }
    return false;
  }
  /// A mark that is off by so much jitters as marks do.
  bool fits(double off) const { return scatter_.evidence(off, std::llround(off)) < MarkScatter::kDoubt; }
  /// A mark some turns later agrees with the one with which it began.
  bool bears_out(const ChainedMark& next) const {
    const auto [turn, off] = place(next);
    return turn > 0 && fits(off);
  }
  void take(double off, std::int64_t slip) {
    const double jitter = off - static_cast<double>(slip);
    marks_ = std::min(marks_ + 1, kMemory_marks);
    position_ += static_cast<double>(slip) + jitter / marks_;
    scatter_.learn(jitter);
  }

 private:
  static constexpr int kMemory_marks = 16;
  const int teeth_;
  double position_ = 0.0;
  int marks_ = 0;
  MarkScatter scatter_;
};

}  // namespace

MarkChain chain_marks(const FollowedRun& run, int teeth) {
  MarkChain chain;
  std::vector<ChainedMark> placed;
  for (const std::int64_t time_ns : run.marks_ns) {
    if (const auto position = position_of(run, time_ns)) placed.push_back({time_ns, *position, 0, 0});
  }
  for (const ChainedMark& mark : placed) chain.placed.push_back(mark.position);
  Expected expected(teeth);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    ChainedMark& mark = placed[i];
    if (chain.marks.empty()) expected.begin(mark);  // until another mark bears it out
    const auto [turn, off] = expected.place(mark);
    const std::int64_t nearest = std::llround(off);
    const auto from_here = std::span<const ChainedMark>(placed).subspan(i);
    const std::int64_t slip = nearest != 0 && expected.slipped(from_here, nearest) ? nearest : 0;
    const bool doubled = !chain.marks.empty() && turn <= chain.marks.back().turn;
    const bool first = chain.marks.empty() && placed.size() > 1;
    const bool false_one = first ? i + 1 == placed.size() || !expected.bears_out(placed[i + 1])
                                 : slip == 0 && !expected.fits(off);
    if (doubled || false_one) {
      ++chain.dropped;
      continue;
    }
    mark.turn = turn;
    mark.slip = slip + (chain.marks.empty() ? 0 : chain.marks.back().slip);
    if (slip != 0) ++chain.slips;
    expected.take(off, slip);
    chain.marks.push_back(mark);
  }
  return chain;
}

namespace {

/// Position by a cubic through two marks with the slopes of their neighbours.
class TurnCubic {
 public:
  TurnCubic(const MarkChain& chain, std::size_t from, int teeth, double place)
      : chain_(chain), teeth_(teeth), place_(place), from_(from) {}

  double position(std::int64_t time_ns) const {
    const ChainedMark &a = chain_.marks[from_], &b = chain_.marks[from_ + 1];
    const double span = static_cast<double>(b.time_ns - a.time_ns);
    const double x = static_cast<double>(time_ns - a.time_ns) / span;
    const double way = at(from_ + 1) - at(from_), in = slope(from_) * span, out = slope(from_ + 1) * span;
    return at(from_) + x * (in + x * (3.0 * way - 2.0 * in - out + x * (in + out - 2.0 * way)));
  }

 private:
  double at(std::size_t k) const { return static_cast<double>(chain_.marks[k].turn) * teeth_ + place_; }
  double slope(std::size_t k) const {
    const std::size_t a = k > 0 ? k - 1 : k, b = std::min(k + 1, chain_.marks.size() - 1);
    return (at(b) - at(a)) / static_cast<double>(chain_.marks[b].time_ns - chain_.marks[a].time_ns);
  }
  const MarkChain& chain_;
  const double teeth_, place_;
  const std::size_t from_;
};

}  // namespace

NumberedRun anchor_run(const FollowedRun& run, const MarkChain& chain, int teeth, double place) {
  NumberedRun numbered;
  double sum = 0.0;
  for (const ChainedMark& mark : chain.marks) {
    numbered.marks_ns.push_back(mark.time_ns);
    sum += mark.position - static_cast<double>(mark.slip + mark.turn * teeth);
  }
  const std::int64_t origin = std::llround(sum / static_cast<double>(chain.marks.size()) - place);
  std::size_t mark = 0;  // the last at or before the tooth; the first for those before it
  for (const NumberedTooth& tooth : run.teeth) {
    while (mark + 1 < chain.marks.size() && chain.marks[mark + 1].time_ns <= tooth.time_ns) ++mark;
    std::int64_t number = tooth.number - origin - chain.marks[mark].slip;
    const bool slipped = mark + 1 < chain.marks.size() && tooth.time_ns > chain.marks[mark].time_ns &&
                         chain.marks[mark + 1].slip != chain.marks[mark].slip;
    if (slipped) {
      const double position = TurnCubic(chain, mark, teeth, place).position(tooth.time_ns);
      number = std::llround(position);
      if (std::abs(position - static_cast<double>(number)) > kGate_pitches) continue;
    }
    if (!numbered.teeth.empty() && number <= numbered.teeth.back().number) continue;
    numbered.teeth.push_back({tooth.time_ns, number});
  }
  return numbered;
}

void declare_faulty_turns(const FollowedRun& run, const MarkChain& chain,
                          std::vector<NumberedTeeth::Turn>& turns) {
  for (std::size_t k = 0; k + 1 < chain.marks.size(); ++k) {
    const ChainedMark &a = chain.marks[k], &b = chain.marks[k + 1];
    const auto fault = std::ranges::lower_bound(run.faults_ns, a.time_ns);
    const bool faulty = fault != run.faults_ns.end() && *fault <= b.time_ns;
    if (faulty || a.slip != b.slip) turns.push_back({a.time_ns, b.time_ns});
  }
}

}  // namespace roadbalance
