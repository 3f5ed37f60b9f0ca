#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "hil_tests/guest/can_player.hpp"
#include "hil_tests/players/frame_program.hpp"
#include "hil_tests/players/timetable.hpp"

namespace roadbalance::test {

/// Sends frames at their time.
class FramePlayer {
 public:
  /// @throws std::system_error naming an interface that is not there
  FramePlayer(std::vector<DriveFrame> frames, const std::vector<std::string>& interfaces,
              Timetable timetable);

  /// Process: ends when all are sent, or when asked to.
  void run(std::stop_token stop);

  /// Lateness of frames when they are handed to the kernel.  After run().
  const Lateness& lateness() const { return lateness_; }

 private:
  const std::vector<DriveFrame> frames_;
  const Timetable timetable_;
  std::vector<std::unique_ptr<CanPlayer>> bus_;
  Lateness lateness_;
};

}  // namespace roadbalance::test
