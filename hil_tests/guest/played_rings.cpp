#include "hil_tests/guest/played_rings.hpp"

#include <utility>
#include <vector>

#include "common/types/clock_pair.hpp"

namespace roadbalance::test {

void PlayedRings::turn(const VehicleConfig& vehicle, double seconds) {
  std::vector<gpio_pulse_step> steps;
  for (std::uint8_t line = 0; line < kEncoderLines; ++line) {
    JudgedRing& ring = rings_[line];
    ring.line = line;
    ring.encoder = vehicle.wheel[line].encoder;
    ring.filter = vehicle.filter;
    ring.program = {3U + 2U * line,
                    4U + 2U * line,
                    ring.encoder.pulses_per_turn,
                    kTurns_hz[line],
                    0,
                    static_cast<int>(seconds * kTurns_hz[line])};
    ring.program.begin_ns = PulseChip::now_ns() + 500'000'000;
    ring.program.add_to(steps);
    ring.machine_minus_monotonic_ns = machine_minus(CLOCK_MONOTONIC).count();
  }
  chip_.play(in_order(std::move(steps)));
}

}  // namespace roadbalance::test
