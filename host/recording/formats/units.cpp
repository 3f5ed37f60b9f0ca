#include "host/recording/formats/units.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <utility>

#include "common/vehicle/gravity.hpp"

namespace roadbalance {
namespace {

constexpr double kInch_m = 0.0254, kFoot_m = 12.0 * kInch_m;  // both exact

struct NamedUnit {
  std::string_view name;
  Unit unit;
};
using enum Quantity;
constexpr std::array kUnits{NamedUnit{"m/s2", {kAcceleration, 1.0}},
                            NamedUnit{"mm/s2", {kAcceleration, 1e-3}},
                            NamedUnit{"cm/s2", {kAcceleration, 1e-2}},
                            NamedUnit{"in/s2", {kAcceleration, kInch_m}},
                            NamedUnit{"ft/s2", {kAcceleration, kFoot_m}},
                            NamedUnit{"g", {kAcceleration, kStandardGravity_m_s2}},
                            NamedUnit{"mg", {kAcceleration, 1e-3 * kStandardGravity_m_s2}},
                            NamedUnit{"m", {kLength, 1.0}},
                            NamedUnit{"mm", {kLength, 1e-3}},
                            NamedUnit{"cm", {kLength, 1e-2}},
                            NamedUnit{"in", {kLength, kInch_m}},
                            NamedUnit{"ft", {kLength, kFoot_m}},
                            NamedUnit{"v", {kVoltage, 1.0}},
                            NamedUnit{"mv", {kVoltage, 1e-3}}};

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

/// One spelling for all: small letters, no blanks, "m/s2".
std::string plain(std::string_view name) {
  std::string text;
  for (const char c : name)
    if (c != ' ') text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kSpellings{
      {{"\xC2\xB2", "2"}, {"\xB2", "2"}, {"**", ""}, {"^", ""}, {"sec", "s"}, {"/s/s", "/s2"}}};
  for (const auto& [from, to] : kSpellings) replace_all(text, from, to);
  return text;
}

}  // namespace

std::optional<Unit> unit_named(std::string_view name) {
  const auto found = std::ranges::find(kUnits, plain(name), &NamedUnit::name);
  return found == kUnits.end() ? std::nullopt : std::optional(found->unit);
}

}  // namespace roadbalance
