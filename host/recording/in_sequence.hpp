#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/record/rescue_disk.hpp"
#include "common/record/segment_index.hpp"

namespace roadbalance {

/// Lets each block of a record through once.
///
/// The recorder writes every node epoch in ascending sequence; after a restart it may write some blocks
/// again. A skipped number is damage, unless a gap of cause kLostAtNode, which bears the number of the last
/// lost block, stands for it; it is counted, and later blocks are as good as ever.  A listener on the bus
/// begins in the midst of an epoch: blocks before the first one it heard are not missing.
class InSequence {
 public:
  enum class From { kItsBegin, kFirstHeard };
  explicit InSequence(From from = From::kItsBegin) : from_(from) {}
  /// Blocks that the retention mode has deleted, or that another folder holds, are not missing.
  /// @throws std::system_error naming the file
  static InSequence of_record(const std::filesystem::path& folder) {
    const RecordBeginning begin = beginning_of(folder, rescue_disk());
    InSequence in_sequence(begin.is_in_other_folder && !begin.before ? From::kFirstHeard : From::kItsBegin);
    if (begin.before)
      for (const auto& [key, epoch] : begin.before->epoch) in_sequence.last_[key] = epoch.position.contiguous;
    return in_sequence;
  }

  /// Calls consume(block) unless it was there before.
  template <typename Consume>
  void add(const SealedBlock& block, Consume&& consume) {
    const std::int64_t before = from_ == From::kItsBegin ? 0 : block.header.sequence - 1;
    std::int64_t& last = last_.try_emplace({block.header.node, block.header.epoch}, before).first->second;
    if (block.header.sequence <= last) return;
    const bool declared = block.kind == BlockKind::kGap && stands_for_lost_blocks(decode_gap(block).cause);
    if (!declared) missing_ += block.header.sequence - last - 1;
    last = block.header.sequence;
    consume(block);
  }

  /// Blocks that are not there and were not declared lost.
  std::int64_t missing() const { return missing_; }

 private:
  From from_;
  std::map<std::pair<std::int32_t, std::int64_t>, std::int64_t> last_;
  std::int64_t missing_ = 0;
};

}  // namespace roadbalance
