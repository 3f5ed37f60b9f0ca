#pragma once

#include <cstdint>

#include "common/link/ring.hpp"
#include "common/link/spool.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// All that a node keeps for its recorder, as one run of sequences base() .. next() - 1: the oldest in the
/// spool if there is one, the newest in the ring.  Used by the ring's consumer thread only; adds no memory
/// but one block.
///
/// When more than half of the ring is used its oldest blocks move to the spool; blocks that the spool does
/// not take stay in the ring.
class Backlog {
 public:
  explicit Backlog(Ring& ring, Spool* spool = nullptr);

  std::int64_t base() const;  ///< oldest sequence held
  std::int64_t next() const { return ring_.next(); }
  std::int64_t used() const { return next() - base(); }  ///< blocks held
  std::int64_t capacity() const;
  std::int64_t spooled() const;         ///< of the blocks held, those on the node's disk
  std::int64_t spool_failures() const;  ///< calls that the node's disk refused

  /// base() <= sequence < next(); valid until the next call of any member.  Nullptr if the node's disk does
  /// not give it back: it is tried again when asked for again.  The oldest block is given up after
  /// `kMostTries` if the disk answers otherwise, and so are those behind it at once if they cannot be read
  /// either: base() rises, and the recorder declares them lost at the node.  A disk that is gone may come
  /// back: it is waited for until three quarters of the ring are used, or the epoch is over for
  /// `kMostTriesAtEnd`.  Then all that it holds is given up.
  const SealedBlock* get(std::int64_t sequence);
  /// Everything through `sequence` < next() is given back; lower than base() does nothing.
  void free_through(std::int64_t sequence);
  /// Moves blocks to the spool if it is time to.  May take as long as a disk does.
  void relieve(WallTime now);
  /// The program ends: moves all that the spool takes, though its disk refuses some calls.
  void save(WallTime now);

  static constexpr int kMostTries = 50;  ///< a second or more: no recorder asks again within 20 ms
  static constexpr int kMostTriesAtEnd = 5 * kMostTries;  ///< half of the time that a stop waits

 private:
  bool is_spooled(std::int64_t sequence) const { return spool_ && sequence < ring_.base(); }
  void not_read(std::int64_t sequence);
  bool may_wait() const;
  void describe();
  void move(std::int64_t blocks, WallTime now);

  Ring& ring_;
  Spool* const spool_;
  std::int64_t described_ = 0;  // the blocks through here describe the epoch; -1: those behind do not
  SealedBlock block_;           // read from the spool
  std::int64_t unread_ = 0;     // the oldest block, if the disk did not give it back ...
  int tries_ = 0;               // ... so often
  bool gave_up_ = false;        // nothing could be read since a block was given up
};

}  // namespace roadbalance
