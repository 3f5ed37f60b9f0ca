#include "firmware/board/sine.hpp"

#include <cmath>
#include <initializer_list>

#include "firmware/board/test/check.hpp"

namespace roadbalance::board::test {

BOARD_TEST(sine_and_cosine_are_those_of_the_library) {
  constexpr double kRad = 6.283185307179586 / 4294967296.0;
  // A step without a common divisor with the turn passes through all octants and close to their borders.
  for (std::uint32_t phase = 0, k = 0; k < 20'000; ++k, phase += 2654435761u) {
    const SineCosine value = sine_cosine(phase);
    CHECK_NEAR(static_cast<double>(value.sine), std::sin(phase * kRad), 3e-7);
    CHECK_NEAR(static_cast<double>(value.cosine), std::cos(phase * kRad), 3e-7);
  }
  for (std::uint32_t octant = 0; octant < 8; ++octant)
    for (const std::uint32_t beside : {0u, 1u, ~0u}) {
      const std::uint32_t phase = (octant << 29) + beside;
      CHECK_NEAR(static_cast<double>(sine_cosine(phase).sine), std::sin(phase * kRad), 3e-7);
    }
}

}  // namespace roadbalance::board::test
