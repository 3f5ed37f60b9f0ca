#include "firmware/backends/gpio/quadrature.hpp"

namespace roadbalance {

void Quadrature::start(std::optional<bool> first, std::optional<bool> second) noexcept {
  level_ = {first, second};
  was_read_ = {true, true};
}

Quadrature::Step Quadrature::take(Track track, bool rising) noexcept {
  // Levels alternate.  Two alike: the edge between is missing, or a late interrupt thread read a level that
  // was over, and the direction of either edge is not known.
  Step step{.lost = level_[track] == rising && !was_read_[track]};
  level_[track] = rising;
  was_read_[track] = false;
  if (track == kA && level_[kB] == false) step.tooth = rising ? EdgeKind::kTooth : EdgeKind::kToothBackward;
  return step;
}

}  // namespace roadbalance
