#pragma once

#include <string>
#include <vector>

#include "tools/study/study.hpp"

namespace roadbalance {

/// Settings of studies of many seeds.
inline const std::vector<std::string> kIdealOptions{"--runs", "--seed", "--state",   "--jobs",
                                                    "--set",  "--svg",  "--markdown"};

/// Studies behind perfect sensors, one file each.
Study estimators_study();    ///< every estimator beside the bound
Study cancellation_study();  ///< table 6
Study influences_study();    ///< speed, size, left on right, frequency difference, stabiliser
Study quantisation_study();  ///< converter and noise
Study equations_study();     ///< order of the filter and number of equations
Study many_drives_study();   ///< one estimate from many drives

}  // namespace roadbalance
