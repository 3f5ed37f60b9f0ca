#pragma once

#include "tools/study/study.hpp"

namespace roadbalance {

/// Studies of the posterior on cars and roads that are not ideal.
Study hazards_study();
Study real_road_study();

}  // namespace roadbalance
