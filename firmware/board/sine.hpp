#pragma once

#include <cstdint>

namespace roadbalance::board {

/// An angle in 2^-32 turns: wraps by itself, and is exact where a float would not be.
using Phase = std::uint32_t;

struct SineCosine {
  float sine;
  float cosine;
};

/// Sine and cosine, to 3e-7 of full scale.
///
/// Taylor's series about the nearest quarter turn, |x| <= pi / 4: the first term left out is x^11 / 11! =
/// 2e-9. The rounding of a float remains.
SineCosine sine_cosine(Phase phase);

}  // namespace roadbalance::board
