#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/board/hardware.hpp"

namespace roadbalance::board::test {

/// A board without a board: its timer stands where the test sets it, its D/A are readable.
class SimulatedHardware final : public Hardware {
 public:
  bool configure(const Configuration& wanted) override {
    if (refuses) return false;
    configuration = wanted;
    return true;
  }
  void start(StartMode mode) override { running = mode; }
  void stop() override { running.reset(); }
  bool level(std::size_t line, Signal signal) const override {
    return levels[line][static_cast<std::size_t>(signal)];
  }
  void write_references(const std::array<std::int16_t, kLoopChannels>& written) override { codes = written; }
  std::uint64_t ticks() const override { return now; }

  std::uint64_t now = 0;
  bool refuses = false;
  Configuration configuration;
  std::optional<StartMode> running;
  std::array<std::array<bool, 3>, kLines> levels{};
  std::array<std::int16_t, kLoopChannels> codes{};
};

}  // namespace roadbalance::board::test
