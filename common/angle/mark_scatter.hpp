#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace roadbalance {

/// How far zero marks scatter about their mean place among the teeth, and so how likely a mark that is off
/// means that the count of teeth has slipped, rather than that its stamp jitters.
class MarkScatter {
 public:
  /// A mark was off its mean place by so many pitches.
  void learn(double off) noexcept {
    marks_ = std::min(marks_ + 1, kMemory_marks);
    const double within = std::min(std::abs(off), kMost_pitches);
    square_ += (within * within - square_) / marks_;
  }
  double variance() const noexcept { return square_; }

  /// Logarithm of how much likelier a mark that is `off` is if the count has slipped by `slip` teeth than if
  /// it has not; 0 for no slip.
  double evidence(double off, std::int64_t slip) const noexcept {
    const auto n = static_cast<double>(slip);
    return (2.0 * off * n - n * n) / (2.0 * square_);
  }
  /// The same, as far as one mark may show it: it could be false.
  double evidence_of_one(double off, std::int64_t slip) const noexcept {
    return std::clamp(evidence(off, slip), -kOfOne, kOfOne);
  }
  /// This mark counts for or against that slip, not another one.
  static bool speaks_of(double off, std::int64_t slip) noexcept {
    return std::abs(off) < 0.5 || std::abs(off - static_cast<double>(slip)) < 1.0;
  }
  /// Less of it is no doubt: of so many turns one looks like that by chance.
  static constexpr double kDoubt = 7.0;
  /// More of it is no chance.
  static constexpr double kSure = 20.0;

 private:
  static constexpr int kMemory_marks = 100;
  static constexpr double kUsual_pitches = 0.2;
  static constexpr double kMost_pitches = 0.5;  // one that is off by more has slipped or is false
  static constexpr double kOfOne = 12.0;        // two that agree are sure

  int marks_ = 4;  // the usual counts as so many, so that the first does not count for all
  double square_ = kUsual_pitches * kUsual_pitches;
};

}  // namespace roadbalance
