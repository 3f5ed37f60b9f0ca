#pragma once

#include <complex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// An electrical sine of known phase on an acceleration channel and the pulses of a ring that turns with it,
/// as from two outputs of one generator.
struct PhaseInjection {
  FilterConfig filter;
  double turns_hz;  ///< in the middle of the measurement
  double scan_rate_hz = 2000.0;
  double phase_rad = 0.7;       ///< of the sine behind the wheel's angle
  double drift_turns_s2 = 0.0;  ///< the sine then grows with the square of the speed, as an unbalance's force
  double sine_late_s = 0.0;     ///< on its way to the converter, as nothing in the chain corrects
};

/// The returned sine over the one that was sent: the sine through the simulated conditioner and its
/// filter, the pulses through the encoder and the filter's digital copy into channels 13 and 14, both sealed
/// into blocks, and 8 s of the channel demodulated by the reference, over the square of their mean speed; a
/// whole number of neither turns nor blocks.  No number where a reference was not known.
/// @param by_mean_speed  not by the reference, but by a sine of the mean frequency: what a drift makes
/// useless
std::complex<double> injected_over_sent(const PhaseInjection& injection, bool by_mean_speed = false);

/// By how much the phase that comes back differs.
double injected_phase_error_deg(const PhaseInjection& injection);

/// A row with keys as in encoder_row_result(): rms and largest of the errors that are numbers, and how many
/// are none ("unknown_blocks").
nlohmann::ordered_json phase_row(const std::string& name, const std::vector<double>& errors_deg);

/// One row for each order of the filter, 4 to 8, with cut-offs of 100 to 400 Hz and 5 to 25 turns a second;
/// as phase_row(); and one for an unbalance while the speed drifts, with "max_percent".
std::vector<nlohmann::ordered_json> phase_injection_rows();

}  // namespace roadbalance
