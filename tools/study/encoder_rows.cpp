#include "tools/study/encoder_rows.hpp"

#include <cmath>
#include <numbers>

#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr double kPitchError_rad = 0.3 * kDegree;

std::function<double(double)> steady(double turns_hz, double torsion_rad = 0.0, double torsion_hz = 13.0) {
  return [=](double t) {
    return 2.0 * pi * turns_hz * t + 0.6 * std::sin(2.0 * pi * 0.21 * t) +
           0.1 * std::sin(2.0 * pi * 0.83 * t + 1.0) + torsion_rad * std::sin(2.0 * pi * torsion_hz * t) +
           1.0;
  };
}

std::function<double(double)> ramp(double from_km_h, double to_km_h, double seconds) {
  constexpr double kRadius_m = 0.3;
  const double from_rad_s = from_km_h / 3.6 / kRadius_m;
  const double rise_rad_s2 = (to_km_h - from_km_h) / 3.6 / kRadius_m / seconds;
  return [=](double t) {
    return (from_rad_s + 0.5 * rise_rad_s2 * t) * t + 0.1 * std::sin(2.0 * pi * 0.83 * t);
  };
}

}  // namespace

std::vector<EncoderRow> encoder_rows() {
  const std::vector<double> ring = sim::pitch_errors(96, kPitchError_rad, 5);
  const auto row = [&](std::string name, double jitter_s, double rms_deg, double max_deg) {
    return EncoderRow{std::move(name),
                      {.angle_rad = steady(18.0), .pitch_error_rad = ring, .jitter_s = jitter_s, .seed = 11},
                      40.0,
                      20.0,
                      rms_deg,
                      max_deg};
  };
  const std::vector<double> off_centre = sim::with_eccentricity(ring, 0.5 * kDegree, 0.4);
  std::vector<EncoderRow> rows{row("96 pulses, 2 us", 2e-6, 0.004, 0.016),
                               row("96 pulses, 10 us", 10e-6, 0.015, 0.06),
                               row("96 pulses, 100 us", 100e-6, 0.09, 0.35),
                               row("96 pulses, 2 us, eccentric", 2e-6, 0.004, 0.016),
                               row("96 pulses, 10 us, eccentric", 10e-6, 0.015, 0.06),
                               row("96 pulses, 100 us, eccentric", 100e-6, 0.09, 0.35)};
  for (std::size_t i = 3; i < 6; ++i) rows[i].train.pitch_error_rad = off_centre;

  rows.push_back(row("96 pulses, 10 us, 1 % lost, 1 % extra", 10e-6, 0.02, 0.09));
  rows.back().train.lost = rows.back().train.extra = 0.01;

  rows.push_back(row("1000 pulses, 10 us", 10e-6, 0.004, 0.016));
  rows.back().train.teeth = 1000;
  rows.back().train.pitch_error_rad = sim::pitch_errors(1000, 0.01 * kDegree, 6);

  constexpr double kUnlimited = std::numeric_limits<double>::infinity();
  rows.push_back(row("ramp 80 to 130 km/h, 2 % pitch errors, 10 % joint", 10e-6, 0.05, kUnlimited));
  rows.back().train.angle_rad = ramp(80.0, 130.0, 90.0);
  rows.back().train.pitch_error_rad = sim::with_joint(sim::pitch_errors(96, 0.02 * 2.0 * pi / 96, 7), 0.1);
  rows.back().seconds = 90.0;
  rows.back().from_s = 60.0;

  for (const double turns_hz : {10.0, 18.0}) {
    rows.push_back(row("96 pulses, 10 us, torsion 1 deg at 13 Hz, wheel at " +
                           std::to_string(static_cast<int>(turns_hz)) + " Hz",
                       10e-6, 0.05, kUnlimited));
    rows.back().train.angle_rad = steady(turns_hz, 1.0 * kDegree);
  }
  return rows;
}

}  // namespace roadbalance
