#pragma once

#include <cstdint>

#include "common/link/ring.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// Where a node moves its oldest blocks when its memory runs short: a run of sequences base() .. next() - 1,
/// none if these are equal.  Used by the ring's consumer thread only; its calls may take as long as a disk
/// does.
class Spool {
 public:
  Spool() = default;
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;
  virtual ~Spool() = default;

  virtual std::int64_t base() const = 0;
  virtual std::int64_t next() const = 0;
  /// Blocks it can hold, of the largest kind.
  virtual std::int64_t capacity() const = 0;
  /// Calls that the disk refused.
  virtual std::int64_t failures() const = 0;

  /// A part of the epoch's description (kMeta); given once, before the first keep().
  virtual void describe(const SealedBlock& meta) = 0;
  /// Adds the ring's blocks `first` .. `last`, as many as it can; blocks it holds on return outlive the
  /// process. `first` is next() unless the spool is empty.
  virtual void keep(const Ring& ring, std::int64_t first, std::int64_t last, WallTime now) = 0;
  /// The program ends: from now on no keep() waits for a disk that has just refused one.
  virtual void never_wait() = 0;
  /// base() <= sequence < next().  False if the disk does not give the block back as it was sealed.
  virtual bool read(std::int64_t sequence, SealedBlock& out) = 0;
  /// The disk takes and keeps something at this moment: blocks that it does not give back are bad, not the
  /// disk.
  virtual bool answers() = 0;
  /// Everything through `sequence` < next() is given back; lower than base() does nothing.
  virtual void free_through(std::int64_t sequence) = 0;
  /// The same for blocks that the disk does not give back: the file they are in stays on it.
  virtual void give_up_through(std::int64_t sequence) = 0;
};

}  // namespace roadbalance
