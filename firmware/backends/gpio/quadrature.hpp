#pragma once

#include <array>
#include <optional>

#include "common/types/scan.hpp"

namespace roadbalance {

/// Distinguishes forward from backward by the second track of a transducer, a quarter of a pitch beside the
/// first.
///
///     forward -->
///     first track    __/~~~\___/~~~\__     a tooth is where the first track rises while the second is low;
///     second track   ____/~~~\___/~~~\     backwards the same place is where the first falls
///
/// With rising edges of the first track alone a wheel that trembles across a tooth could not be distinguished
/// from one that turns; so both edges of both tracks are needed.  For a transducer mounted the other way
/// round exchange the tracks: tooth_gpio and direction_gpio.  Edges come in order of time.
class Quadrature {
 public:
  enum Track : std::uint8_t { kA, kB };

  struct Step {
    bool lost = false;                   ///< an edge of this track is missing before this one
    std::optional<EdgeKind> tooth = {};  ///< kTooth, kToothBackward
  };

  /// Begins anew.  @param first, second  levels about now, if they could be read
  void start(std::optional<bool> first, std::optional<bool> second) noexcept;
  /// Edges of either track may be missing before the next one.
  void forget() noexcept { start(std::nullopt, std::nullopt); }

  Step take(Track track, bool rising) noexcept;

 private:
  std::array<std::optional<bool>, 2> level_;
  std::array<bool, 2> was_read_{};  ///< and not seen in an edge yet: it may already be over
};

}  // namespace roadbalance
