#pragma once

#include <cstdint>
#include <span>

#include "common/link/blocks.hpp"

namespace roadbalance {

/// Takes what a node measured from one instant to another, in order: scans and gaps tile that time.
class EpochSink {
 public:
  EpochSink() = default;
  EpochSink(const EpochSink&) = delete;
  EpochSink& operator=(const EpochSink&) = delete;
  virtual ~EpochSink() = default;

  /// The next scans; of the header only scans and time_ns count.
  virtual void scans(const ScanBlock& block) = 0;
  /// So many scans are not there, the first of them at time_ns; 0: edges or signals alone were lost.
  virtual void gap(std::int64_t scans, std::int64_t time_ns, GapCause cause) = 0;
  /// In order of time; no further from the scans given so far than in the recording that they come from.
  virtual void edges(std::span<const Edge> edges) = 0;
  virtual void signals(std::span<const SignalSample> samples) = 0;

  enum class Ending {
    kEnd,    ///< that is all
    kCrash,  ///< the node crashed: what came after is unknown
    kOpen,   ///< what came after is unknown, nobody says why
  };
  virtual void end(Ending ending) = 0;
};

}  // namespace roadbalance
