#include "tools/rb/weighted_drive.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

std::optional<double> number(const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

WeightedDrive WeightedDrive::parse(const std::string& text) {
  const auto colon = text.rfind(':');
  const std::string last = colon == std::string::npos ? text : text.substr(colon + 1);
  // Weights, right or wrong, are not of a folder's name; neither is a slash of theirs.
  const bool weighted = last.find('/') == std::string::npos &&
                        (colon == std::string::npos ? last.find('@') : last.find('=')) != std::string::npos;
  if (!weighted) return {text, {}};
  if (colon == std::string::npos || colon == 0)
    throw ConfigError(text + ": no recording before the weights; allowed: DIR:PLANE=GRAMS@DEGREES,...");
  WeightedDrive drive{text.substr(0, colon), {}};
  std::istringstream weights(last);
  for (std::string one; std::getline(weights, one, ',');) {
    const auto is = one.find('='), angle = one.find('@');
    const bool formed = is != std::string::npos && angle != std::string::npos && 0 < is && is < angle;
    const auto grams = formed ? number(one.substr(is + 1, angle - is - 1)) : std::nullopt;
    const auto degrees = formed ? number(one.substr(angle + 1)) : std::nullopt;
    if (!grams || !degrees || *grams < 0.0)
      throw ConfigError(text + ": \"" + one + "\" is no weight; allowed: PLANE=GRAMS@DEGREES, grams >= 0");
    drive.weight.push_back({one.substr(0, is), std::polar(*grams, *degrees * std::numbers::pi / 180.0)});
  }
  return drive;
}

std::vector<std::complex<double>> WeightedDrive::in_planes(const RotorConfig& rotor) const {
  std::vector<std::complex<double>> all(rotor.plane.size());
  for (const Weight& one : weight) {
    const auto plane = std::ranges::find(rotor.plane, one.plane, &PlaneConfig::name);
    if (plane == rotor.plane.end()) {
      std::string there;
      for (const PlaneConfig& each : rotor.plane) there += " " + each.name;
      throw ConfigError(one.plane + ": rotor " + rotor.name +
                        " has no such plane; allowed:" + (there.empty() ? " none" : there));
    }
    all[static_cast<std::size_t>(plane - rotor.plane.begin())] += one.weight_g;
  }
  return all;
}

}  // namespace roadbalance
