#include "host/analysis/calibration/datum_readings.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>
#include <numbers>

#include "common/config/set_value.hpp"
#include "common/text/format.hpp"

namespace roadbalance {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kDegrees = 180.0 / std::numbers::pi;

}  // namespace

double DatumReadings::pitch_rad() const {
  return kTurn_rad / config_.pulses_per_turn;
}

void DatumReadings::add(const Edge& edge) {
  const std::int64_t time_ns = to_ns(edge.time);
  switch (edge.kind) {
    case EdgeKind::kZeroMark:
      if (backward_) return;
      tooth_ = 0;
      mark_ns_ = time_ns;
      place_.reset();
      return;
    case EdgeKind::kTooth:
      // Across one pitch a hand turns evenly enough.
      if (mark_ns_ && last_tooth_ns_ && time_ns > *last_tooth_ns_) {
        place_ = static_cast<double>(time_ns - *mark_ns_) / static_cast<double>(time_ns - *last_tooth_ns_);
      }
      last_tooth_ns_ = time_ns;
      backward_ = false;
      if (tooth_) ++*tooth_;
      break;
    case EdgeKind::kToothBackward:
      backward_ = true;
      last_tooth_ns_.reset();
      if (tooth_) --*tooth_;
      break;
    case EdgeKind::kLost:
      last_tooth_ns_.reset();
      tooth_.reset();
      break;
  }
  mark_ns_.reset();
}

/// Middle of where the wheel may stand: tooth n lies at n - 1 + place.  No tooth has come since the mark: it
/// stands between the mark and the first one.
double DatumReadings::since_mark_pitches() const {
  const double place = place_.value_or(0.5);
  return mark_ns_ ? 0.5 * place : static_cast<double>(*tooth_) - 0.5 + place;
}

double DatumReadings::read(double angle_rad) {
  assert(can_read());
  const double datum_rad = std::remainder(angle_rad - since_mark_pitches() * pitch_rad(), kTurn_rad);
  datum_rad_.push_back(datum_rad);
  tooth_.reset();
  return datum_rad;
}

void DatumReadings::undo() {
  if (!datum_rad_.empty()) datum_rad_.pop_back();
}

std::optional<DatumReadings::Datum> DatumReadings::datum() const {
  if (datum_rad_.size() < 2) return std::nullopt;
  std::complex<double> sum = 0.0;
  for (const double reading : datum_rad_) sum += std::polar(1.0, reading);
  Datum datum{std::arg(sum), 0.0, 0.0, 0.0};
  double square = 0.0;
  for (const double reading : datum_rad_) {
    const double off = std::remainder(reading - datum.datum_rad, kTurn_rad);
    square += off * off;
    if (std::abs(off) > std::abs(datum.worst_rad)) datum.worst_rad = off;
  }
  const auto count = static_cast<double>(datum_rad_.size());
  datum.scatter_rad = std::max(std::sqrt(square / (count - 1.0)), pitch_rad() / std::sqrt(12.0));
  datum.sigma_rad = datum.scatter_rad / std::sqrt(count);
  return datum;
}

std::string DatumReadings::objection() const {
  const auto found = datum();
  if (!found || std::abs(found->worst_rad) <= kFarthest_rad) return {};
  return format(
      "the readings do not agree: one is %.0f deg from their mean. Was the clock read from outside, and the "
      "wheel turned forward only?",
      std::abs(found->worst_rad) * kDegrees);
}

DatumText datum_text(double datum_rad, double sigma_rad) {
  const double sigma_deg = std::max(0.01, std::ceil(100.0 * sigma_rad * kDegrees) / 100.0);
  return {toml_number(datum_rad * kDegrees, 2), toml_number(sigma_deg, 2)};
}

}  // namespace roadbalance
