#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/board/angle_tracker.hpp"
#include "firmware/board/encoder_capture.hpp"
#include "firmware/board/protocol.hpp"

namespace roadbalance::board {

/// Makes the D/A's sine and cosine of each wheel's angle, so that the references go through the same real
/// anti-aliasing filters as the accelerations and come back as the last four channels.
class ReferenceGenerator {
 public:
  using Codes = std::array<std::int16_t, kLoopChannels>;
  static constexpr float kFullScaleCode = 32767.0f;

  /// Begins a run; while no interrupt comes.
  void start(const ReferenceSetup& setup, const Configuration& configuration, std::uint32_t tick_hz);

  /// Interrupt: a tooth or zero mark.
  void follow(const CapturedEdge& edge);

  /// Interrupt: the codes for the angle at this instant; 0 for a wheel whose angle is not known.
  Codes codes(std::uint64_t ticks);

  /// Main loop: bit k: wheel k's codes were an angle the last time.
  std::uint32_t locked() const { return locked_.load(std::memory_order_relaxed); }

 private:
  struct Wheel {
    bool on = false;
    std::uint8_t line = 0;
    float amplitude = 0.0f;  ///< in codes
    Phase datum = 0;
    AngleTracker tracker;
  };
  std::array<Wheel, kLoopChannels / 2> wheels_{};
  std::atomic<std::uint32_t> locked_ = 0;
};

}  // namespace roadbalance::board
