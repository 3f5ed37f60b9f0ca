#include "hil_tests/guest/ring_judge.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <complex>
#include <deque>
#include <numbers>
#include <optional>

#include "common/angle/wheel_encoder.hpp"

namespace roadbalance::test {
namespace {

using std::numbers::pi;

/// Delay of a Butterworth low-pass, from its poles (A. Oppenheim, R. Schafer, Discrete-Time Signal
/// Processing, 3rd ed., app. B.1): that of an even rotation.
double lag_rad(const FilterConfig& filter, double frequency_hz) {
  double lag = 0.0;
  for (int k = 0; k < filter.order; ++k) {
    const auto pole = std::polar(1.0, pi / 2.0 + pi * (2 * k + 1) / (2.0 * filter.order));
    lag += std::arg(1.0 - std::complex<double>(0.0, frequency_hz / filter.cutoff_hz) / pole);
  }
  return lag;
}

/// From one zero mark that was read to the next.
struct Turn {
  NodeTime begin, end;
  bool is_whole, has_lost;
};

/// There is an angle shortly before the mark that ends it.
bool gives_angle(const WheelEncoder& encoder, const Turn& turn) {
  constexpr NodeClock::duration kShortly = std::chrono::milliseconds(20);
  std::array<double, 1> angle;
  return encoder.angles(turn.end - std::min(kShortly, (turn.end - turn.begin) / 2), 0.0, angle);
}

void judge(TurnVerdict& verdict, const Turn& turn, const WheelEncoder& encoder) {
  if (turn.is_whole)
    ++verdict.whole;
  else if (turn.has_lost || encoder.uncertain(turn.begin, turn.end) || !gives_angle(encoder, turn))
    ++verdict.declared;
  else
    ++verdict.silent;
}

}  // namespace

std::string TurnVerdict::text() const {
  return std::to_string(whole) + " turns whole, " + std::to_string(declared) + " declared faulty, " +
         std::to_string(silent) + " faulty in silence";
}

TurnVerdict judge_turns(std::span<const Edge> edges, const JudgedRing& ring) {
  TurnVerdict verdict;
  WheelEncoder encoder(ring.encoder);
  std::deque<Turn> open;  // judged as late as a node asks: a later tooth may add information
  std::optional<NodeTime> mark;
  std::int64_t teeth = 0;
  int marks = 0;
  bool lost = false;
  for (const Edge& edge : edges) {
    if (edge.line != ring.line) continue;
    for (; !open.empty() && edge.time > encoder.complete_at(open.front().end); open.pop_front())
      judge(verdict, open.front(), encoder);
    encoder.add(edge.time, edge.kind);
    if (edge.kind == EdgeKind::kTooth) ++teeth;
    if (edge.kind == EdgeKind::kLost) lost = true;
    if (edge.kind != EdgeKind::kZeroMark) continue;
    // The first mark or the second locates the ring: there is nothing to be wrong before.
    if (mark && ++marks > 2) {
      const double turns =
          std::round(std::chrono::duration<double>(edge.time - *mark).count() * ring.program.turns_hz);
      open.push_back({*mark, edge.time, teeth == std::llround(turns * ring.program.teeth), lost});
    }
    mark = edge.time;
    teeth = 0;
    lost = false;
  }
  for (const Turn& turn : open) judge(verdict, turn, encoder);
  return verdict;
}

std::string AngleVerdict::text() const {
  return std::to_string(right) + " angles right, " + std::to_string(flagged) + " flagged (" +
         std::to_string(flagged_wrong) + " of them wrong), " + std::to_string(silent_wrong) +
         " wrong in silence; " + std::to_string(strict) +
         " judged to less than a pitch, the worst of the unflagged off by " +
         std::to_string(worst_silent_pitches) + " pitches";
}

bool is_flagged(const ScanBlock& block, std::uint8_t line) {
  const std::int32_t uncertain = line == 0 ? kQualityUncertainAngle0 : kQualityUncertainAngle1;
  return (block.quality & (quality_no_reference(line) | uncertain)) != 0;
}

AngleVerdict judge_angles(std::span<const ScanBlock> blocks, const JudgedRing& ring,
                          const std::function<double(std::int64_t monotonic_ns)>& allowed_pitches) {
  AngleVerdict verdict;
  const double lag = lag_rad(ring.filter, ring.program.turns_hz) - ring.encoder.datum_rad;
  const auto sine = static_cast<std::size_t>(kAccelerations + 2 * ring.line);
  for (const ScanBlock& block : blocks) {
    const bool flagged = is_flagged(block, ring.line);
    for (std::int64_t row = 0; row < block.header.scans; ++row) {
      const auto& counts = block.counts[static_cast<std::size_t>(row)];
      const std::int64_t at_ns = ring.monotonic_ns(node_time_from_ns(block.row_time_ns(row)));
      const bool known = counts[sine] != 0 || counts[sine + 1] != 0;
      const double angle = std::atan2(counts[sine], counts[sine + 1]);
      const double truth = 2.0 * pi * ring.program.turns_at(at_ns) - lag;
      const double off = std::abs(std::remainder(angle - truth, 2.0 * pi)) / (2.0 * pi) * ring.program.teeth;
      const double allowed = allowed_pitches(at_ns);
      const bool wrong = !known || off > 0.5 + allowed;
      if (flagged) {
        ++verdict.flagged;
        verdict.flagged_wrong += known && wrong;
        continue;
      }
      verdict.strict += allowed < 0.5;
      ++(wrong ? verdict.silent_wrong : verdict.right);
      verdict.worst_silent_pitches = std::max(verdict.worst_silent_pitches, off);
    }
  }
  return verdict;
}

}  // namespace roadbalance::test
