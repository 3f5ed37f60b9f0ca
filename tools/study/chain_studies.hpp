#pragma once

#include "tools/study/study.hpp"

namespace roadbalance {

/// Studies of the whole identification behind imperfect sensors and encoders, one file each.
Study end_to_end_study();    ///< table 11
Study coverage_study();      ///< what the stated ellipses cover
Study radial_force_study();  ///< table 8

}  // namespace roadbalance
