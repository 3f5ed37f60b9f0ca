#pragma once

#include <array>
#include <cstddef>

namespace roadbalance {

/// Judges whether the zero marks of a wheel name one tooth of it, by where they lie among the teeth.
///
/// Two marks a turn (a magnet and the head of a bolt) and a ring of another number of teeth give an angle
/// that looks right and is wrong.  Marks that name a tooth lie at one place for the most part; a second mark
/// lies at a place of its own between them, and on a ring of other teeth the place wanders from turn to turn.
/// A place that jumps once is that of a count of teeth that has slipped, which ZeroMarks puts right.
class MarkCount {
 public:
  explicit MarkCount(int teeth) : teeth_(teeth) {}

  /// The next mark.
  /// @param position  pitches, by the count of teeth
  void add(double position) noexcept;
  /// Teeth were lost: the count begins anew, and the judgement stands until there are marks again.
  void forget() noexcept { size_ = bad_ = 0; }

  /// They name a tooth, as far as is known; false until two marks lie a whole number of turns apart.
  bool trusted() const noexcept { return trusted_; }
  /// If they do not: the teeth that were counted between marks, the most frequent number first; 0: none
  /// (yet).
  std::array<int, 2> counts() const noexcept;

  static constexpr std::size_t kWindow = 12;  ///< marks of late

 private:
  /// Pitches between the places of two marks, at most half a turn.
  double apart(std::size_t a, std::size_t b) const noexcept;
  bool judged() const noexcept;

  const int teeth_;
  std::array<double, kWindow> position_{};  ///< of the latest marks, in order of time
  std::size_t size_ = 0;
  std::size_t bad_ = 0;  ///< marks in a row by which they name no tooth
  bool trusted_ = false;
};

}  // namespace roadbalance
