#include "tools/views/weight_check_line.hpp"

#include <algorithm>
#include <cmath>

#include "common/config/vehicle_config.hpp"
#include "common/text/format.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

const char* said(WeightCheckVerdict verdict) {
  switch (verdict) {
    case WeightCheckVerdict::kOpen:
      return "not known well enough yet: drive on";
    case WeightCheckVerdict::kGood:
      return "good: no more is left than a shop leaves";
    case WeightCheckVerdict::kLess:
      return "better, and more is left than a shop leaves";
    case WeightCheckVerdict::kUnchanged:
      return "NO BETTER than before";
    case WeightCheckVerdict::kMore:
      return "WORSE than before";
  }
  return "";
}

const char* said(WeightPlacement placement) {
  switch (placement) {
    case WeightPlacement::kNotJudged:
      return "";
    case WeightPlacement::kAsWanted:
      return "; it changed as the weights should change it";
    case WeightPlacement::kMirrored:
      return "; it changed as if the weight were MIRRORED at the valve: angles count in the direction of "
             "rotation, seen "
             "from outside";
    case WeightPlacement::kOpposite:
      return "; it changed as if the weight were AT the heavy spot, not opposite to it";
    case WeightPlacement::kElsewhere:
      return "; it did not change as the weights should change it: are they where they should be?";
    case WeightPlacement::kNoEffect:
      return "; it did not change: were the weights fitted?";
  }
  return "";
}

const char* name_of(WeightCheckVerdict verdict) {
  constexpr const char* kNames[]{"open", "good", "less", "unchanged", "more"};
  return kNames[static_cast<int>(verdict)];
}

const char* name_of(WeightPlacement placement) {
  constexpr const char* kNames[]{"not_judged", "as_wanted", "mirrored", "opposite", "elsewhere", "no_effect"};
  return kNames[static_cast<int>(placement)];
}

const char* name_of(WeightCheckState state) {
  constexpr const char* kNames[]{"reading_before", "not_comparable", "before_unknown", "after_unknown",
                                 "known"};
  return kNames[static_cast<int>(state)];
}

}  // namespace

std::string weight_check_line(const WeightCheck& v) {
  switch (v.state) {
    case WeightCheckState::kReadingBefore:
      return "the drive before (" + v.text + ") is being read";
    case WeightCheckState::kNotComparable:
      return "no comparison: " + v.text;
    case WeightCheckState::kBeforeUnknown:
      return "no comparison: the drive before (" + v.text + ") did not tell this wheel";
    case WeightCheckState::kAfterUnknown:
      return format("before (%s) %.1f g; this drive does not tell it yet", v.text.c_str(), v.before_g.norm());
    case WeightCheckState::kKnown:
      break;
  }
  return format("before (%s) %.1f g, now %.1f g: %.0f %% %s, ± %.0f %%; %s%s", v.text.c_str(),
                v.before_g.norm(), v.after_g.norm(), 100.0 * std::abs(v.reduction),
                v.reduction < 0.0 ? "more" : "less", std::max(1.0, std::ceil(100.0 * v.sigma_reduction)),
                said(v.verdict), said(v.placement));
}

Json weight_check_json(const WeightCheck& v) {
  const auto vector = [](const Eigen::Vector2d& value) { return Json{value.x(), value.y()}; };
  const bool has_before = v.state == WeightCheckState::kKnown || v.state == WeightCheckState::kAfterUnknown;
  const bool is_known = v.state == WeightCheckState::kKnown;
  const auto if_known = [](bool known, Json value) { return known ? std::move(value) : Json(nullptr); };
  return {{"wheel", kWheelNames.at(static_cast<std::size_t>(v.wheel))},
          {"state", name_of(v.state)},
          {"text", v.text},
          {"before_g", if_known(has_before, vector(v.before_g))},
          {"after_g", if_known(is_known, vector(v.after_g))},
          {"fitted_g", if_known(has_before, vector(v.fitted_g))},
          {"fitted_from_vehicle_toml", v.fitted_known},
          {"weight_radius_m", v.weight_radius_m},
          {"reduction", if_known(is_known, v.reduction)},
          {"sigma_reduction", if_known(is_known, v.sigma_reduction)},
          {"verdict", name_of(v.verdict)},
          {"placement", name_of(v.placement)}};
}

}  // namespace roadbalance
