#include "common/angle/zero_marks.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {

namespace {
constexpr double kFalse_turns = 0.15;
constexpr int kMostFalse = 3;
constexpr std::int64_t kManyFaults = 2;
constexpr double kClear_pitches = 0.35;  // of a whole number of teeth
constexpr int kMemory = 4000, kMemoryWhileLearning = 8;
}  // namespace

std::int64_t ZeroMarks::locate(double position) noexcept {
  const std::int64_t tooth = std::llround(position - place_);
  if (!known_) place_ = position - static_cast<double>(tooth);
  known_ = true;
  resume();
  return tooth;
}

void ZeroMarks::resume() noexcept {
  turn_ = 0;
  doubted_slip_ = 0;
  false_in_a_row_ = 0;
}

ZeroMarks::Verdict ZeroMarks::judge(double position, std::int64_t faults, bool learning) noexcept {
  const double phase = position - place_;
  const std::int64_t turn = std::llround(phase / teeth_);
  const double off = phase - static_cast<double>(turn) * teeth_;
  if (turn <= turn_ || std::abs(off) > std::max(0.6, kFalse_turns * teeth_))
    return ++false_in_a_row_ < kMostFalse ? Verdict::kFalse : Verdict::kInsists;
  false_in_a_row_ = 0;
  turn_ = turn;
  slip_ = std::llround(off);
  const bool clear = std::abs(off - static_cast<double>(slip_)) < kClear_pitches;
  if (clear && faults > kManyFaults && scatter_.evidence(off, slip_) > MarkScatter::kSure)
    return end_doubt(Verdict::kSlipped);
  if (doubted_slip_ == 0 || !MarkScatter::speaks_of(off, doubted_slip_)) {
    doubted_slip_ = slip_;
    doubt_ = 0.0;
  }
  doubt_ += scatter_.evidence_of_one(off, doubted_slip_);
  if (doubt_ > MarkScatter::kSure) {
    slip_ = doubted_slip_;
    return end_doubt(Verdict::kSlipped);
  }
  if (doubt_ > MarkScatter::kDoubt) return Verdict::kDoubted;
  if (doubt_ <= 0.0) doubted_slip_ = 0;
  slip_ = 0;
  learn(off, learning);
  return Verdict::kFits;
}

ZeroMarks::Verdict ZeroMarks::end_doubt(Verdict verdict) noexcept {
  doubted_slip_ = 0;
  return verdict;
}

void ZeroMarks::learn(double off, bool learning) noexcept {
  weight_ = std::min(weight_ + 1, learning ? kMemoryWhileLearning : kMemory);
  place_ += off / weight_;
  scatter_.learn(off);
}

double ZeroMarks::sigma() const noexcept {
  return weight_ == 0 ? 0.5 : std::sqrt(scatter_.variance() / weight_);
}

}  // namespace roadbalance
