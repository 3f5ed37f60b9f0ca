#pragma once

#include "tools/study/study.hpp"

namespace roadbalance {

/// Studies that are computed exactly, with nothing to repeat, one file each.
Study fig4_study();        ///< table 9
Study parameters_study();  ///< table 7

}  // namespace roadbalance
