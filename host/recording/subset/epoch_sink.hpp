#pragma once

#include <cstdint>
#include <span>

#include "common/types/blocks.hpp"

namespace roadbalance {

/// Takes the measurements of a node from one instant to another, in order: scans and gaps tile that time.
class EpochSink {
 public:
  EpochSink() = default;
  EpochSink(const EpochSink&) = delete;
  EpochSink& operator=(const EpochSink&) = delete;
  virtual ~EpochSink() = default;

  /// The next scans; scans and time_ns are the only fields of the header that count.
  virtual void scans(const ScanBlock& block) = 0;
  /// So many scans are missing, the first of them at time_ns; 0: only edges or signals were lost.
  virtual void gap(std::int64_t scans, std::int64_t time_ns, GapCause cause) = 0;
  /// In order of time; no further from the scans given so far than in their recording.
  virtual void edges(std::span<const Edge> edges) = 0;
  virtual void signals(std::span<const SignalSample> samples) = 0;

  enum class Ending {
    kEnd,    ///< nothing more was measured
    kCrash,  ///< the node crashed: the rest is unknown
    kOpen,   ///< the rest is unknown, and so is the reason
  };
  virtual void end(Ending ending) = 0;
};

}  // namespace roadbalance
