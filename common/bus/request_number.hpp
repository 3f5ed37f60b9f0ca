#pragma once

#include <cstdint>
#include <random>

#include "common/bus/operation.hpp"

namespace roadbalance {

/// A number that no other asker or recorder will have, 1 .. kRequestLimit - 1.
inline std::int64_t random_number() {
  std::random_device device;
  return std::uniform_int_distribution<std::int64_t>(1, kRequestLimit - 1)(device);
}

}  // namespace roadbalance
