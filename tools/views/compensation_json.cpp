#include "tools/views/compensation_json.hpp"

#include <numbers>

#include "tools/views/degrees.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

const char* name_of(WeightAction action) {
  switch (action) {
    case WeightAction::kKeep:
      return "keep";
    case WeightAction::kMove:
      return "move";
    case WeightAction::kRemove:
      return "remove";
    case WeightAction::kAdd:
      return "add";
  }
  return "unknown";
}

Json name_of(WeightKind kind) {
  switch (kind) {
    case WeightKind::kNotGiven:
      return nullptr;
    case WeightKind::kClip:
      return "clip";
    case WeightKind::kAdhesive:
      return "adhesive";
  }
  return nullptr;
}

Json name_of(RimPlane plane) {
  switch (plane) {
    case RimPlane::kNotGiven:
      return nullptr;
    case RimPlane::kInner:
      return "inner";
    case RimPlane::kOuter:
      return "outer";
  }
  return nullptr;
}

Json name_of(Advice advice) {
  switch (advice) {
    case Advice::kUnknown:
      return nullptr;
    case Advice::kSteps:
      return "steps";
    case Advice::kLeaveUncertain:
      return "leave_uncertain";
    case Advice::kLeaveSmall:
      return "leave_small";
  }
  return "unknown";
}

}  // namespace

Json steps_json(const WeightPlan& plan) {
  Json steps = Json::array();
  for (const WeightStep& step : plan.step) {
    steps.push_back({{"action", name_of(step.action)},
                     {"mass_g", step.weight.mass_g},
                     {"angle_deg", degrees(step.weight.angle_rad)},
                     {"radius_m", step.weight.place.radius_m},
                     {"kind", name_of(step.weight.place.kind)},
                     {"plane", name_of(step.weight.place.plane)}});
    if (step.action == WeightAction::kMove)
      steps.back().update({{"from_deg", degrees(step.from.angle_rad)},
                           {"from_radius_m", step.from.place.radius_m},
                           {"from_plane", name_of(step.from.place.plane)}});
  }
  return steps;
}

Json compensation_json(const std::array<Balance, kWheels>& balance,
                       const std::array<Compensation, kWheels>& compensation) {
  Json wheels = Json::array();
  for (std::size_t w = 0; w < kWheels; ++w) {
    const BalanceVerdict& verdict = compensation[w].verdict;
    const auto known = [&](auto value) {
      return compensation[w].advice == Advice::kUnknown ? Json(nullptr) : Json(value);
    };
    const bool speeds = verdict.permissible_g > 0.0;
    wheels.push_back(
        {{"name", kWheelNames[w]},
         {"advice", name_of(compensation[w].advice)},
         {"steps", known(steps_json(compensation[w].plan))},
         {"of", known("correction")},
         {"least_speed_km_h", known(3.6 * balance[w].least_speed_m_s)},
         {"greatest_speed_km_h", known(3.6 * balance[w].greatest_speed_m_s)},
         {"residual_g", known(verdict.residual_g)},
         {"shop_g", known(verdict.shop_g)},
         {"within_shop", known(verdict.within_shop())},
         {"grade_mm_s", speeds ? Json(verdict.grade_mm_s) : Json(nullptr)},
         {"permissible_grade_mm_s", known(verdict.permissible_grade_mm_s)},
         {"permissible_g", speeds ? Json(verdict.permissible_g) : Json(nullptr)},
         {"judged_by", speeds ? Json(verdict.by_rotor ? "rotating mass" : "unsprung mass") : Json(nullptr)},
         {"force_left_share", known(verdict.force_left_share)},
         {"incurable", verdict.incurable.empty() ? Json(nullptr) : Json(verdict.incurable)}});
  }
  return wheels;
}

}  // namespace roadbalance
