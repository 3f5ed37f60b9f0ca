#pragma once

#include <string>

#include "host/analysis/orders/orders_of_record.hpp"

namespace roadbalance {

/// Uncertainty of a rotor's angle in a recording beyond its references.
struct AngleUncertainty {
  bool located = true;            ///< by zero marks of all its wheels
  double common_sigma_rad = 0.0;  ///< that is the same all through the drive; the datum apart
  double sigma_rad = 0.0;         ///< of an instant, this included
  bool counted = false;           ///< on the bus, or by recorded pulses
  bool by_speed = false;          ///< of the bus: only spectra hold
  std::string contradiction{};    ///< what speaks against its wheels' zero marks, for people; empty: nothing
};

AngleUncertainty angle_uncertainty(const RecordOrders& found, const Rotor& rotor);

}  // namespace roadbalance
