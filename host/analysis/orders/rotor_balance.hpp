#pragma once

#include <complex>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/balance/influence.hpp"
#include "host/analysis/orders/rotor_orders.hpp"

namespace roadbalance {

/// A drive with known weights in a rotor's planes.
struct WeightedRun {
  std::vector<std::complex<double>> weight_g;  ///< [plane] at its angle from the rotor's own mark; 0: none
  std::vector<const RotorOrders*> orders;      ///< of that rotor, order 1 first; one for each node
  double datum_rad = 0.0;                      ///< that its angle was counted with (datum_of)
  double phase_sigma_rad = 0.0;                ///< of its angle, the same all through the drive
};

struct RotorBalance {
  std::string refusal;                 ///< why there are no weights, and what would help; empty: there are
  bool by_amplitude = false;           ///< four runs without phase; else influence coefficients
  std::vector<PlaneCorrection> plane;  ///< to put on the bare rotor, as RotorConfig::plane
  int observations =
      0;  ///< channels times classes of speed that all runs have; by amplitude: that determine it
  std::string observation{};                 ///< by amplitude: the surest of them, whose weight this is
  double rms_before = 0.0, rms_after = 0.0;  ///< of their amplitudes, m/s^2; by influence
  double condition = 1.0;                    ///< InfluenceBalance::condition; by influence
  double agreement = 1.0;                    ///< by amplitude: of the runs with one another, 1 is best
};

/// Weights from drives of a rotor: its first order in every channel and class of speed that all drives have.
///
/// Where its angle is the same in all drives (Rotor::known_share is 1) by influence coefficients in all
/// planes (balance_by_influence), all phases turned back to the first drive's datum.  Else no phase of one
/// drive can be compared with another's, and only a bare drive and three or more with the same trial weight
/// at different angles of one plane determine a weight (balance_by_four_runs), by the observation in which
/// that weight does most.
RotorBalance balance_rotor(const RotorConfig& rotor, const std::vector<WeightedRun>& runs);

}  // namespace roadbalance
