#include "host/analysis/angle/mark_place.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kPlacesTried = 64;
constexpr std::size_t kWindow = 16, kAgree = 12;
constexpr std::size_t kBetween = 8;  // a smoother makes a slope of a step

bool lies_at(const PlacedMark& mark, double place, double pulses, double width) {
  return std::abs(std::remainder(mark.position - place, pulses)) < width;
}

/// Nothing if they do not agree.
std::optional<double> common_place(std::span<const PlacedMark> marks, double pulses, double width) {
  const double place = densest_place(marks, pulses, width);
  double sum = 0.0;
  std::size_t near = 0;
  for (const PlacedMark& mark : marks) {
    if (!lies_at(mark, place, pulses, width)) continue;
    sum += std::remainder(mark.position - place, pulses);
    ++near;
  }
  if (near < kAgree) return std::nullopt;
  return place + sum / static_cast<double>(near);
}

}  // namespace

double mean_place(std::span<const PlacedMark> marks, double pulses) {
  std::complex<double> sum = 0.0;
  for (const PlacedMark& mark : marks) sum += std::polar(1.0, kTurn * mark.position / pulses);
  return std::arg(sum) * pulses / kTurn;
}

double scatter_about(std::span<const PlacedMark> marks, double place, double pulses) {
  double square = 0.0;
  for (const PlacedMark& mark : marks) square += std::pow(std::remainder(mark.position - place, pulses), 2);
  return std::sqrt(square / static_cast<double>(std::max<std::size_t>(marks.size(), 1)));
}

double densest_place(std::span<const PlacedMark> marks, double pulses, double width) {
  double best = 0.0;
  std::ptrdiff_t most = -1;
  // A sample of all, that keeps step with nothing.
  const std::size_t asked = std::min(marks.size(), kPlacesTried);
  for (std::size_t k = 0; k < asked; ++k) {
    const double part = std::fmod(static_cast<double>(k) * std::numbers::phi, 1.0);
    const double at = marks[static_cast<std::size_t>(part * static_cast<double>(marks.size()))].position;
    const auto near = std::ranges::count_if(
        marks, [&](const PlacedMark& mark) { return lies_at(mark, at, pulses, width); });
    if (near <= most) continue;
    most = near;
    best = at;
  }
  return best;
}

std::optional<MovedPlace> first_move(std::span<const PlacedMark> marks, double pulses, double width) {
  for (std::size_t end = kWindow; end + kBetween + kWindow <= marks.size(); ++end) {
    const auto before = common_place(marks.subspan(end - kWindow, kWindow), pulses, width);
    const auto behind = common_place(marks.subspan(end + kBetween, kWindow), pulses, width);
    if (!before || !behind || std::abs(std::remainder(*behind - *before, pulses)) <= width) continue;
    const auto first = marks.begin() + static_cast<std::ptrdiff_t>(end - kWindow);
    const auto last = first + static_cast<std::ptrdiff_t>(2 * kWindow + kBetween);
    const auto at_behind =
        std::find_if(first + static_cast<std::ptrdiff_t>(kAgree), last,
                     [&](const PlacedMark& mark) { return lies_at(mark, *behind, pulses, 0.5 * width); });
    auto at_before = at_behind;
    while (at_before != first && !lies_at(*(at_before - 1), *before, pulses, 0.5 * width)) --at_before;
    if (at_behind == last || at_before == first) continue;
    return MovedPlace{(at_before - 1)->time_ns, at_behind->time_ns};
  }
  return std::nullopt;
}

}  // namespace roadbalance
