#include "host/analysis/calibration/loop_back_comparison.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

namespace roadbalance {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr double kLeast_s = 5.0;        ///< to be compared
constexpr double kSilence = 0.02;       ///< of full scale
constexpr double kForeignShare = 0.02;  ///< of power: noise of a converter is far less
constexpr double kMostUneven = 0.005;   ///< 0.3 degrees twice a turn
constexpr double kLeastSpread = 0.10;   ///< of speed, from which on a delay differs from a constant
constexpr double kLeastRotation_hz = 2.0;

std::complex<double> phasor(const std::array<std::int32_t, kChannels>& counts, std::size_t line) {
  return std::complex<double>(counts[kAccelerations + 2 * line + 1], counts[kAccelerations + 2 * line]) /
         static_cast<double>(kFullScaleCounts);
}

using Cause = LoopBackComparison::Cause;

Cause cause_of_angle(const LoopBackComparison::Verdict& verdict, bool fitted, double tolerance_rad) {
  if (!fitted) return Cause::kAngle;
  const double by_delay = std::abs(kTwoPi * verdict.worst_hz * verdict.delay_s);
  if (std::abs(verdict.constant_rad) <= std::max(tolerance_rad, 0.25 * by_delay)) return Cause::kFilter;
  if (by_delay <= std::max(tolerance_rad, 0.25 * std::abs(verdict.constant_rad))) return Cause::kDatum;
  return Cause::kAngle;
}

/// A quarter turn of the phase: 0 along, 1 ahead by 90 degrees, 2 against, 3 behind.
int quarter(std::complex<double> h) {
  return (static_cast<int>(std::lround(std::arg(h) / (0.25 * kTwoPi))) + 4) % 4;
}

}  // namespace

void LoopBackComparison::add(const ScanBlock& recorded, const ComputedReferences::Rows& computed) {
  const BlockHeader& header = recorded.header;
  const bool follows = header.epoch == epoch_ && header.first_scan == next_scan_;
  epoch_ = header.epoch;
  next_scan_ = header.first_scan + header.scans;
  std::array<bool, kEncoderLines> known{};
  for (std::size_t line = 0; line < kEncoderLines; ++line) {
    // Until the node has the angle, the board need not have it either.
    known[line] = ((computed.quality | recorded.quality) & quality_no_reference(static_cast<int>(line))) == 0;
    if (!follows || !known[line]) line_[line].follows = false;
  }
  for (std::size_t row = 0; row < static_cast<std::size_t>(header.scans); ++row)
    add_row(recorded.counts[row], computed.counts[row], known);
}

void LoopBackComparison::add_row(const std::array<std::int32_t, kChannels>& back,
                                 const std::array<std::int32_t, kChannels>& made,
                                 const std::array<bool, kEncoderLines>& known) {
  for (std::size_t n = 0; n < kEncoderLines; ++n) {
    if (!known[n]) continue;
    Line& line = line_[n];
    const std::complex<double> m = phasor(back, n), c = phasor(made, n);
    const double turns_hz = std::arg(c * std::conj(line.last)) / kTwoPi * rate_hz_;
    line.last = c;
    if (!std::exchange(line.follows, true) || turns_hz < kLeastRotation_hz) continue;
    ++line.rows;
    if (std::abs(m) < kSilence) ++line.silent;
    Class& here = line.of_speed[static_cast<int>(turns_hz / kClass_hz)];
    here.straight += m * std::conj(c);
    here.mirrored += m * c;
    here.power += std::norm(c);
    here.turns_hz += turns_hz;
    ++here.rows;
    const Eigen::Vector2d came(m.imag(), m.real());
    line.power += came.cwiseAbs2();
    // A wheel that is not there explains nothing.
    const std::complex<double> c0 = known[0] ? phasor(made, 0) : 0.0, c1 = known[1] ? phasor(made, 1) : 0.0;
    const Eigen::Vector4d x(c0.imag(), c0.real(), c1.imag(), c1.real());
    line.with += came * x.transpose();
    line.among += x * x.transpose();
  }
}

LoopBackComparison::Verdict LoopBackComparison::verdict(std::size_t n, double tolerance_rad) const {
  const Line& line = line_[n];
  Verdict verdict;
  verdict.seconds = static_cast<double>(line.rows) / rate_hz_;
  if (verdict.seconds < kLeast_s) return verdict;
  const Eigen::Vector2d rms = (line.power / static_cast<double>(line.rows)).cwiseSqrt();
  const auto decide = [&](Cause cause) {
    verdict.cause = cause;
    return verdict;
  };
  if (2 * line.silent > line.rows || rms.maxCoeff() < kSilence) return decide(Cause::kSilent);
  if (rms.minCoeff() < kSilence) return decide(Cause::kOneSilent);

  const Eigen::Matrix<double, 4, 2> A =
      line.among.completeOrthogonalDecomposition().solve(line.with.transpose());
  const double explained = (A.transpose() * line.among * A).trace();
  verdict.unexplained = std::max(0.0, 1.0 - explained / line.power.sum());
  const auto own = static_cast<Eigen::Index>(2 * n);
  const double of_own = A.middleRows<2>(own).squaredNorm(), of_other = A.middleRows<2>(2 - own).squaredNorm();
  if (verdict.unexplained > kForeignShare) return decide(Cause::kForeign);
  if (of_other > of_own) return decide(Cause::kLinesSwapped);

  std::complex<double> straight, mirrored;
  double power = 0.0;
  for (const auto& [key, one] : line.of_speed) {
    straight += one.straight;
    mirrored += one.mirrored;
    power += one.power;
  }
  verdict.gain = std::max(std::abs(straight), std::abs(mirrored)) / power;
  if (std::abs(mirrored) > std::abs(straight)) {
    constexpr std::array kMirrored{Cause::kSineInverted, Cause::kSwapped, Cause::kCosineInverted,
                                   Cause::kSwappedInverted};
    return decide(kMirrored[static_cast<std::size_t>(quarter(mirrored))]);
  }
  verdict.uneven = std::abs(mirrored) / std::abs(straight);
  verdict.mean_rad = std::arg(straight);
  const bool fitted = fit_speed(line, verdict);
  // A filter delays; wires turn by a quarter, at all speeds.
  constexpr std::array kStraight{Cause::kNone, Cause::kSwappedInverted, Cause::kBothInverted,
                                 Cause::kSwappedInverted};
  if (const Cause cause = kStraight[static_cast<std::size_t>(quarter(std::polar(1.0, verdict.constant_rad)))];
      cause != Cause::kNone)
    return decide(cause);
  if (verdict.uneven > kMostUneven) return decide(Cause::kUneven);
  return decide(std::abs(verdict.worst_rad) <= tolerance_rad
                    ? Cause::kNone
                    : cause_of_angle(verdict, fitted, tolerance_rad));
}

/// Least squares of the phase over the speed classes, weighted by their rows.  False if the speeds are too
/// much alike to separate a delay from a constant: then all is taken for a constant.
bool LoopBackComparison::fit_speed(const Line& line, Verdict& verdict) {
  double w = 0.0, wf = 0.0, wff = 0.0, wp = 0.0, wfp = 0.0;
  for (const auto& [key, one] : line.of_speed) {
    const double rows = static_cast<double>(one.rows), f = one.turns_hz / rows;
    if (rows < 0.01 * static_cast<double>(line.rows)) continue;  // passed through
    // Counted from the mean, so that a phase near half a turn does not jump.
    const double phase = verdict.mean_rad + std::arg(one.straight * std::polar(1.0, -verdict.mean_rad));
    if (std::abs(phase) > std::abs(verdict.worst_rad)) verdict.worst_rad = phase, verdict.worst_hz = f;
    w += rows, wf += rows * f, wff += rows * f * f, wp += rows * phase, wfp += rows * f * phase;
  }
  verdict.constant_rad = verdict.mean_rad;
  if (w == 0.0) return false;
  const double spread = (wff - wf * wf / w) / w, mean = wf / w;
  if (spread <= std::pow(0.3 * kLeastSpread * mean, 2)) return false;
  const double slope = (wfp - wf * wp / w) / (w * spread);
  verdict.delay_s = -slope / kTwoPi;
  verdict.constant_rad = (wp - slope * wf) / w;
  return true;
}

namespace {

/// Delay at rest of a Butterworth filter: sum of 2 sin((2 k - 1) pi / 2 n), k to n / 2, and 1 if n is odd,
/// over its corner.
double delay_at_rest(const FilterConfig& filter) {
  double sum = filter.order % 2 == 1 ? 1.0 : 0.0;
  for (int k = 1; k <= filter.order / 2; ++k)
    sum += 2.0 * std::sin((2 * k - 1) * std::numbers::pi / (2 * filter.order));
  return sum / (kTwoPi * filter.cutoff_hz);
}

std::string of_filter(const LoopBackComparison::Verdict& verdict, const FilterConfig& filter) {
  const double nominal_s = delay_at_rest(filter), real_s = nominal_s + verdict.delay_s;
  char text[300];
  if (real_s <= 0.1 * nominal_s)
    std::snprintf(
        text, sizeof text,
        "it comes back %.1f us early, nearly as if it passed no filter: is the loop closed behind the "
        "filter?",
        -1e6 * verdict.delay_s);
  else
    std::snprintf(text, sizeof text,
                  "it comes back %.1f us %s than the filter of vehicle.toml (order %d, %g Hz) makes it; of "
                  "this order that is one of %.1f Hz: check [filter] and what is fitted",
                  1e6 * std::abs(verdict.delay_s), verdict.delay_s < 0.0 ? "earlier" : "later", filter.order,
                  filter.cutoff_hz, filter.cutoff_hz * nominal_s / real_s);
  return text;
}

}  // namespace

std::string explain(const LoopBackComparison::Verdict& verdict, const FilterConfig& filter) {
  switch (verdict.cause) {
    case Cause::kNone:
      return {};
    case Cause::kTooShort:
      return "less than 5 s of turning wheel with a known angle: drive a little";
    case Cause::kSilent:
      return "nothing comes back: is the D/A converter connected to the filter's input, and are references "
             "on?";
    case Cause::kOneSilent:
      return "only one of sine and cosine comes back: look at the wire of the other";
    case Cause::kForeign:
      return "what comes back is no wheel's sine and cosine: another signal is on these inputs, or a channel "
             "clips";
    case Cause::kLinesSwapped:
      return "it is the other wheel's: the lines of the two wheels are swapped, at the encoders or in the "
             "loop";
    case Cause::kSineInverted:
      return "the sine is inverted: swap its two wires";
    case Cause::kCosineInverted:
      return "the cosine is inverted: swap its two wires";
    case Cause::kBothInverted:
      return "sine and cosine are both inverted (or the datum given to the board is 180 degrees off)";
    case Cause::kSwapped:
      return "sine and cosine are swapped";
    case Cause::kSwappedInverted:
      return "sine and cosine are swapped, and one or both inverted";
    case Cause::kUneven:
      return "sine and cosine do not come back alike: their gains or filters differ; rb calibrate channels "
             "tells";
    case Cause::kFilter:
      return of_filter(verdict, filter);
    case Cause::kDatum:
      return "the angle is off by the same at all speeds: the board was given another datum or zero mark";
    case Cause::kAngle:
      return "the angle is off; drive at two speeds or more to tell a wrong filter from a wrong datum";
  }
  return {};
}

}  // namespace roadbalance
