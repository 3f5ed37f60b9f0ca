#include "tools/report/report_wheel.hpp"

#include <cmath>

#include "common/text/format.hpp"

namespace roadbalance {
namespace {

constexpr double kRim = 40.0, kTyreRadius = 52.0;

struct Point {
  double x, y;
};

/// On the drawing, y downwards.  Seen from outside a left wheel turns counter-clockwise
/// (common/vehicle/conventions.md).
Point place(int wheel, double radius, double angle_rad) {
  const double clockwise = wheel % 2 == 0 ? -1.0 : 1.0;
  return {clockwise * radius * std::sin(angle_rad), -radius * std::cos(angle_rad)};
}

std::string disc(int wheel, double angle_rad, const std::string& kind) {
  const auto [x, y] = place(wheel, kRim, angle_rad);
  return format("<circle class=\"%s\" cx=\"%.2f\" cy=\"%.2f\" r=\"5\"/>", kind.c_str(), x, y);
}

/// Parts that the wheel hides from a person beside the car are hollow.
std::string weight(int wheel, const WheelWeight& at, const std::string& kind) {
  return disc(wheel, at.angle_rad, kind + (at.place.plane == RimPlane::kInner ? " hidden" : ""));
}

std::string weights(const Balance& balance, const Compensation& compensation) {
  std::string svg;
  if (compensation.advice != Advice::kSteps) return svg;
  for (const WeightStep& step : compensation.plan.step) {
    if (step.action == WeightAction::kMove) svg += weight(balance.wheel, step.from, "off");
    const std::string kind = step.action == WeightAction::kRemove ? "off"
                             : step.action == WeightAction::kKeep ? "kept"
                                                                  : "new";
    svg += weight(balance.wheel, step.weight, kind);
  }
  return svg;
}

std::string rotation(int wheel) {
  const auto [x0, y0] = place(wheel, 46.0, 0.3);
  const auto [x1, y1] = place(wheel, 46.0, 0.9);
  const auto [x2, y2] = place(wheel, 46.0, 1.1);
  const auto [x3, y3] = place(wheel, 42.0, 0.88);
  const auto [x4, y4] = place(wheel, 50.0, 0.88);
  return format("<path class=\"turn\" d=\"M%.2f %.2fA46 46 0 0 %d %.2f %.2f\"/>", x0, y0, wheel % 2, x1, y1) +
         format("<path class=\"tip\" d=\"M%.2f %.2fL%.2f %.2fL%.2f %.2fz\"/>", x2, y2, x3, y3, x4, y4);
}

}  // namespace

bool tells_before(const WeightCheck& check) {
  return check.state == WeightCheckState::kKnown || check.state == WeightCheckState::kAfterUnknown;
}

std::string wheel_svg(const Balance& balance, const Compensation& compensation, double rim_g,
                      const WeightCheck* before) {
  std::string svg = format(
      "<svg class=\"wheel\" viewBox=\"-60 -60 120 120\" aria-hidden=\"true\"><circle class=\"tyre\" "
      "r=\"%.0f\"/><circle "
      "class=\"rim\" r=\"%.0f\"/><path class=\"mark\" d=\"M0 -42l-5 -10h10z\"/>",
      kTyreRadius, kRim);
  svg += rotation(balance.wheel);
  if (before != nullptr && tells_before(*before)) {
    const double angle_rad = std::atan2(before->before_g.y(), before->before_g.x());
    const auto [x, y] = place(balance.wheel, kRim * before->before_g.norm() / rim_g, angle_rad);
    svg += format("<path class=\"before\" d=\"M0 0L%.2f %.2f\"/>", x, y);
  }
  if (balance.state == Unknown::kNone) {
    const auto [x, y] = place(balance.wheel, kRim * balance.unbalance_g / rim_g, balance.angle_rad);
    svg += format("<path class=\"vector\" d=\"M0 0L%.2f %.2f\"/>", x, y);
    svg += weights(balance, compensation) + disc(balance.wheel, balance.angle_rad, "spot");
  } else {
    svg += "<text y=\"8\">?</text>";
  }
  return svg + "</svg>";
}

}  // namespace roadbalance
