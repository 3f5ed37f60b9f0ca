#include "firmware/board/sine.hpp"

namespace roadbalance::board {

SineCosine sine_cosine(Phase phase) {
  constexpr float kRadPerPhase = 1.4629180792671596e-9f;  // 2 pi / 2^32
  constexpr Phase kEighthTurn = 1u << 29;
  const Phase quarter = (phase + kEighthTurn) >> 30;
  const float x = static_cast<float>(static_cast<std::int32_t>(phase - (quarter << 30))) * kRadPerPhase;
  const float s = x * x;
  const float sine = x * (1.0f + s * (-1.0f / 6 + s * (1.0f / 120 + s * (-1.0f / 5040 + s / 362880))));
  const float cosine =
      1.0f + s * (-1.0f / 2 + s * (1.0f / 24 + s * (-1.0f / 720 + s * (1.0f / 40320 - s / 3628800))));
  switch (quarter) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

}  // namespace roadbalance::board
