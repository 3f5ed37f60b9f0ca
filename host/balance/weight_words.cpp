#include <cmath>
#include <numbers>

#include "common/text/format.hpp"
#include "host/balance/weight_choice.hpp"
#include "host/balance/weight_plan.hpp"

namespace roadbalance {
namespace {

/// " on the outer flange", " in the inner plane", with the radius where that is not the only one.
std::string on_place(const WeightPlace& place, bool with_radius) {
  const std::string radius = format("%.0f mm", 1e3 * place.radius_m);
  if (place.plane == RimPlane::kUntold) return with_radius ? " on " + radius : "";
  const std::string side = place.plane == RimPlane::kInner ? "inner" : "outer";
  return (place.kind == WeightKind::kClip ? " on the " + side + " flange" : " in the " + side + " plane") +
         (with_radius ? " (" + radius + ")" : "");
}

std::string angle(const WheelWeight& weight) {
  return format("%ld°", std::lround(wrap_turn(weight.angle_rad) * 180.0 / std::numbers::pi) % 360);
}

std::string one_that_is_there(const WheelWeight& weight) {
  switch (weight.place.kind) {
    case WeightKind::kUntold:
      return format("%g g", weight.mass_g);
    case WeightKind::kClip:
      return format("the %g g clip", weight.mass_g);
    case WeightKind::kAdhesive:
      return format("the %g g adhesive weight", weight.mass_g);
  }
  return "";
}

const char* putting(WeightKind kind) {
  switch (kind) {
    case WeightKind::kUntold:
      return "add";
    case WeightKind::kClip:
      return "clip";
    case WeightKind::kAdhesive:
      return "stick";
  }
  return "";
}

}  // namespace

std::string to_string(const WeightStep& step, int radii) {
  const WheelWeight& weight = step.weight;
  const std::string there = " at " + angle(weight) + on_place(weight.place, radii > 1);
  switch (step.action) {
    case WeightAction::kKeep:
      return "keep " + one_that_is_there(weight) + there;
    case WeightAction::kMove:
      return "move " + one_that_is_there(step.from) + " from " + angle(step.from) +
             (step.from.place == weight.place ? "" : on_place(step.from.place, radii > 1)) + " to " +
             angle(weight) + on_place(weight.place, radii > 1);
    case WeightAction::kRemove:
      return "remove " + one_that_is_there(weight) + there;
    case WeightAction::kAdd:
      return putting(weight.place.kind) + format(" %g g", weight.mass_g) + there;
  }
  return "";
}

}  // namespace roadbalance
