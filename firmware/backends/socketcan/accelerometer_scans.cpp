#include "firmware/backends/socketcan/accelerometer_scans.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace roadbalance {
namespace {

constexpr int kShift = 8;  // from 16 bits to the 24 of a scan
constexpr std::int64_t kPartModulus = 1 << 8;
constexpr std::int64_t kWholeModulus = 1LL << 32;
// In conversions.  Numbers and stamps agree so well unless the module began anew: reading may be late by half
// a second, which eight bits cannot distinguish from a module that began anew; for those see the header.
constexpr double kAgreement = 500.0, kAgreementOfParts = 20.0, kAgreementAtZero = 2.0;
constexpr double kShortestStart = 10.0;
constexpr double kModuleClock = 1e-3;  // may be wrong by so much of the time that passed

}  // namespace

std::optional<Scan> AccelerometerScans::add(const AccelerometerFrame& frame, NodeTime time,
                                            bool after_absence) noexcept {
  after_absence_ = after_absence_ || after_absence;
  const int part = frame.part.value_or(0);
  if (part == 0) {
    scan_ = Scan{};
    scan_.time = time;
    next_part_ = 0;
    part_sequence_ = frame.sequence;
  }
  // A part whose predecessors are missing cannot be used; the next scan's number shows the loss.
  if (part != next_part_ || frame.sequence != part_sequence_) {
    next_part_ = AccelerometerFrame::kParts;
    return std::nullopt;
  }
  ++next_part_;
  scan_.overload |= frame.overload;
  const auto first = static_cast<std::size_t>(part * AccelerometerFrame::kChannelsOfPart);
  const std::size_t count = frame.part ? AccelerometerFrame::kChannelsOfPart : frame.sample.size();
  for (std::size_t k = first; k < first + count; ++k) scan_.counts[k] = frame.sample[k] * (1 << kShift);
  if (!frame.part) return finish(frame.sequence, kWholeModulus);
  return next_part_ == AccelerometerFrame::kParts ? finish(frame.sequence, kPartModulus) : std::nullopt;
}

std::optional<Scan> AccelerometerScans::finish(std::uint32_t sequence, std::int64_t modulus) noexcept {
  bool after_absence = std::exchange(after_absence_, false);
  if (started_) {
    const Step step = step_to(sequence, modulus);
    if (step.conversions == 0) {
      ++repeated_;
      after_absence_ = after_absence;
      return std::nullopt;
    }
    after_absence = after_absence || step.began_anew;
    if (!after_absence) missing_ += step.conversions - 1;
    next_index_ += step.conversions - 1;
  }
  started_ = true;
  last_sequence_ = sequence;
  last_time_ = scan_.time;
  scan_.index = next_index_++;
  scan_.after_absence = after_absence;
  return scan_;
}

AccelerometerScans::Step AccelerometerScans::step_to(std::uint32_t sequence,
                                                     std::int64_t modulus) const noexcept {
  const std::int64_t counted = (static_cast<std::int64_t>(sequence) - last_sequence_ + modulus) % modulus;
  const double elapsed = to_seconds(scan_.time - last_time_) * kRateHz;
  const double turns =
      std::max(0.0, std::round((elapsed - static_cast<double>(counted)) / static_cast<double>(modulus)));
  const std::int64_t step = counted + static_cast<std::int64_t>(turns) * modulus;
  double agreement = kAgreement;
  if (modulus == kPartModulus && counted != 1 && elapsed > kShortestStart)
    agreement = sequence == 0 ? kAgreementAtZero : kAgreementOfParts;
  const double off = std::abs(static_cast<double>(step) - elapsed);
  if (off > agreement + kModuleClock * elapsed)
    return {std::max<std::int64_t>(1, std::llround(elapsed)), true};
  return {step, false};
}

}  // namespace roadbalance
