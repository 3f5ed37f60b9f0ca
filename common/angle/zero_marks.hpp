#pragma once

#include <cstdint>

#include "common/angle/mark_scatter.hpp"

namespace roadbalance {

/// Judges each zero mark by its place among the teeth, and learns its mean place.
///
/// The marks show which tooth is which, but one alone may be missing, doubled, late or false: a count of
/// teeth that is off is put right at once only if many teeth were at fault since the mark before, else when
/// enough of the marks after it agree (Page's test: E. S. Page, Continuous inspection schemes, Biometrika 41,
/// 1954): the next one, or a few where marks jitter by a good part of a pitch.
class ZeroMarks {
 public:
  explicit ZeroMarks(int teeth) : teeth_(teeth) {}

  enum class Verdict {
    kFits,     ///< as expected
    kFalse,    ///< twice in a turn or far from its place: it is not counted
    kDoubted,  ///< it or the count of teeth is off by slip() teeth: the next mark decides
    kSlipped,  ///< the count of teeth is off by slip()
    kInsists,  ///< so many false ones in a row are right: the count of teeth means nothing
  };
  /// @param position  of the wheel at the mark, pitches from the tooth that is taken for the mark's
  /// @param faults    teeth at fault since the last mark
  /// @param learning  the pitch table still changes, and the place of the mark with it
  Verdict judge(double position, std::int64_t faults, bool learning) noexcept;
  std::int64_t slip() const noexcept { return slip_; }
  /// Whole turns from the tooth that is taken for the mark's, of the last mark that counted.
  std::int64_t turn() const noexcept { return turn_; }

  /// The tooth that a mark at this position names, by the mean place of marks if that is known.
  std::int64_t locate(double position) noexcept;

  /// The teeth were found again without a mark: turns count from there.
  void resume() noexcept;
  bool known() const noexcept { return known_; }

  /// Mean place of the mark, pitches after the tooth it names.
  double place() const noexcept { return place_; }
  /// Standard deviation of place(), pitches.
  double sigma() const noexcept;

 private:
  void learn(double off, bool learning) noexcept;
  Verdict end_doubt(Verdict verdict) noexcept;

  const int teeth_;
  bool known_ = false;
  double place_ = 0.0;  ///< mean, pitches
  int weight_ = 0;
  MarkScatter scatter_;
  std::int64_t turn_ = 0, slip_ = 0;
  std::int64_t doubted_slip_ = 0;
  double doubt_ = 0.0;  ///< evidence of that slip so far
  int false_in_a_row_ = 0;
};

}  // namespace roadbalance
