#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "common/types/blocks.hpp"
#include "hil_tests/deterministic/hashed_sample.hpp"
#include "hil_tests/deterministic/truth.hpp"

namespace roadbalance::test {

/// Holds one recorder's record against the truth, event by event as they lie in it.
///
/// Each block is there once, in sequence, with the bytes its node sealed; each sample is the hash of its
/// place; scans run on from block to block and gap to gap; what is not there is declared, and nothing that
/// was promised is.  Shares with the product only the decoding of a block.
class RecordCheck {
 public:
  explicit RecordCheck(Truth& truth) : truth_(truth) {}

  /// An acknowledgement of this recorder called everything through `sequence` durable.
  void promised(std::int32_t node, std::int64_t epoch, std::int64_t sequence);
  /// This recorder declares a gap with number `sequence`: nothing in it may have been promised before.
  void declared(std::int32_t node, std::int64_t epoch, std::int64_t sequence);
  /// @param recording  in which it lies, of a recorder that is operated
  void take(std::string_view channel, std::span<const std::uint8_t> bytes, const std::string& recording = {});
  /// The record is whole: what each epoch must have by now.
  /// @param closed  its recorder ended in order and was the only one, so that every epoch has an end or a
  ///                declared crash
  void finish(bool closed);
  /// Its end or its declared crash was seen.
  bool is_closed(std::int32_t node, std::int64_t epoch) const;
  /// Promises for an epoch before its record is read; null: none.
  struct Said {
    std::int64_t promised = 0;  ///< by this recorder: durable through
    struct Declared {
      std::int64_t promised = 0;   ///< by this recorder, then
      std::int64_t released = 0;   ///< by any, then
      bool may_lack_more = false;  ///< the node had been killed or was gone, or its own disk had failed, then
    };
    std::map<std::int64_t, Declared> declared;  ///< [sequence of a gap]
  };
  const Said* said(std::int32_t node, std::int64_t epoch) const;
  /// The last sequence seen of an epoch.
  std::int64_t checked(std::int32_t node, std::int64_t epoch) const;

  std::int64_t blocks() const { return blocks_; }
  std::int64_t declared_scans() const { return declared_scans_; }  ///< in gaps of any cause
  std::int64_t declared_gaps() const { return declared_gaps_; }    ///< of no scans, too; but for late starts
  std::int64_t lost_scans() const { return lost_scans_; }          ///< missing and not declared
  std::int64_t crash_tail_scans() const { return crash_tail_scans_; }

 private:
  using Key = std::pair<std::int32_t, std::int64_t>;
  struct Seen {
    EpochTruth* truth = nullptr;
    std::optional<std::string> recording;
    HashedScans samples;
    Said said;
    std::int64_t sequence = 0;  // last one
    std::int64_t next_scan = 0;
    bool is_next_known = true;  // else an unknown number more were lost with the last gap
    BlockSum sum;               // of the blocks that its node sealed ...
    bool all_its_own = true;    // ... and all are
    bool crashed = false;
    bool ended = false;
  };
  Seen& seen(Key key);
  void lies_in(const std::string& recording, const BlockHeader& header, Seen& seen);
  void take_own(const SealedBlock& block, Seen& seen);
  void take_declared(const SealedBlock& block, Seen& seen);
  void take_scans(const SealedBlock& block, Seen& seen);
  void check_samples(const ScanBlock& block, const HashedScans& samples);
  void run_on(const BlockHeader& header, Seen& seen);
  void finish(Seen& seen, bool closed);
  void fault(const BlockHeader& header, const std::string& what);

  Truth& truth_;
  std::map<Key, Seen> seen_;
  SealedBlock block_;
  std::int64_t blocks_ = 0;
  std::int64_t declared_scans_ = 0;
  std::int64_t declared_gaps_ = 0;
  std::int64_t lost_scans_ = 0;
  std::int64_t crash_tail_scans_ = 0;
};

}  // namespace roadbalance::test
