#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <queue>
#include <random>
#include <span>
#include <vector>

#include "common/types/clocks.hpp"

namespace roadbalance::test {

/// Faults of the frames that leave one end of a cable, independently for every end they go to.
struct CableFaults {
  double loss = 0;                        ///< probability
  double duplicates = 0;                  ///< probability that a frame comes twice
  std::chrono::microseconds shortest{0};  ///< delay; different delays are what reorders frames
  std::chrono::microseconds longest{0};
};

/// A bad Ethernet hub, as a pure state machine: a frame from one end goes to all others, or is lost, doubled,
/// late, or overtaken.  Time comes in with every call; the same seed and calls give the same faults.
class Cable {
 public:
  struct Frame {
    std::size_t to = 0;
    std::vector<std::uint8_t> bytes;
  };
  struct Counts {
    std::int64_t carried = 0;  ///< copies delivered, second ones included
    std::int64_t lost = 0;
    std::int64_t duplicated = 0;
    std::int64_t unplugged = 0;  ///< copies from or to an end that was pulled out
  };

  Cable(std::size_t ends, std::uint32_t seed) : ends_(ends), random_(seed) {}

  void set_faults(std::size_t from, const CableFaults& faults) { ends_.at(from).faults = faults; }
  /// Nothing goes in or out of a pulled end; what was under way to it is lost.
  void pull(std::size_t end) { ends_.at(end).plugged = false; }
  void plug(std::size_t end) { ends_.at(end).plugged = true; }

  void take(std::size_t from, std::span<const std::uint8_t> frame, WallTime now);
  /// The next frame that has arrived by now.
  std::optional<Frame> arrived(WallTime now);
  /// When the next one arrives.
  std::optional<WallTime> next_arrival() const;
  const Counts& counts() const { return counts_; }

 private:
  struct End {
    CableFaults faults;
    bool plugged = true;
  };
  struct UnderWay {
    WallTime due;
    std::int64_t number;  // frames of one instant keep their order
    Frame frame;
    bool operator>(const UnderWay& other) const {
      return due != other.due ? due > other.due : number > other.number;
    }
  };
  bool happens(double probability) { return std::bernoulli_distribution(probability)(random_); }
  void send(const CableFaults& faults, std::size_t to, std::span<const std::uint8_t> frame, WallTime now);

  std::vector<End> ends_;
  std::mt19937 random_;
  std::priority_queue<UnderWay, std::vector<UnderWay>, std::greater<>> under_way_;
  std::int64_t number_ = 0;
  Counts counts_;
};

}  // namespace roadbalance::test
