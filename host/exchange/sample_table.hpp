#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace roadbalance {

/// Samples that somebody else took, before vehicle.toml gives each channel its place.
struct SampleTable {
  std::vector<std::string> name = {};              ///< of each channel; the time column is not one
  std::vector<double> time_s = {};                 ///< [row], never falling
  std::vector<std::vector<double>> value_si = {};  ///< [channel][row], SI; NaN: there is no sample
};

}  // namespace roadbalance
