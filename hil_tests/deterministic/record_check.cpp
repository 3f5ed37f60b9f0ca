#include "hil_tests/deterministic/record_check.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"

namespace roadbalance::test {

void RecordCheck::fault(const BlockHeader& header, const std::string& what) {
  truth_.fault("node " + std::to_string(header.node) + " epoch " + std::to_string(header.epoch) + " block " +
               std::to_string(header.sequence) + ": " + what);
}

RecordCheck::Seen& RecordCheck::seen(Key key) {
  Seen& seen = seen_[key];
  if (!seen.truth) {
    seen.truth = truth_.find(key.first, key.second);
    seen.samples = HashedScans(key.first, key.second);
  }
  return seen;
}

void RecordCheck::promised(std::int32_t node, std::int64_t epoch, std::int64_t sequence) {
  Said& of = seen({node, epoch}).said;
  of.promised = std::max(of.promised, sequence);
}

void RecordCheck::declared(std::int32_t node, std::int64_t epoch, std::int64_t sequence) {
  Seen& of = seen({node, epoch});
  RecordCheck::Said::Declared then{.promised = of.said.promised};
  if (of.truth) {
    then.released = of.truth->promised;
    then.may_lack_more = of.truth->killed || of.truth->gone || of.truth->gave_up;
  }
  of.said.declared[sequence] = then;
}

void RecordCheck::take(std::string_view channel, std::span<const std::uint8_t> bytes,
                       const std::string& recording) {
  if (!channel.starts_with(kBlockChannels)) return;
  if (accept(bytes, block_) != Refusal::kNone) return truth_.fault("a block in the record is not good");
  const BlockHeader& header = block_.header;
  if (channel != block_channel(header.node, block_.kind)) return fault(header, "is on a foreign channel");
  if (header.sequence == 0) return;  // a segment's description of itself
  ++blocks_;
  Seen& of = seen({header.node, header.epoch});
  if (!of.truth) return fault(header, "is of an epoch that nobody began");
  if (of.recording != recording) lies_in(recording, header, of);
  if (of.crashed) fault(header, "comes behind the declared crash");
  const EpochTruth::Block* own = of.truth->block(header.sequence);
  if (own && own->crc == crc_of(block_))
    take_own(block_, of);
  else
    take_declared(block_, of);
}

void RecordCheck::lies_in(const std::string& recording, const BlockHeader& header, Seen& of) {
  if (of.recording)
    fault(header, "lies in \"" + recording + "\", those before it in \"" + *of.recording + "\"");
  of.recording = recording;
  if (!truth_.may_be_in(*of.truth, recording))
    fault(header, "lies in \"" + recording + "\", its node was started for another");
}

// As the node sealed it.
void RecordCheck::take_own(const SealedBlock& block, Seen& of) {
  const BlockHeader& header = block.header;
  if (header.sequence <= of.sequence) return fault(header, "is there twice or out of order");
  if (header.sequence > of.sequence + 1)
    fault(header, "follows block " + std::to_string(of.sequence) + ": those between are lost");
  of.sequence = header.sequence;
  take_scans(block, of);
  declared_gaps_ += block.kind == BlockKind::kGap && decode_gap(block).cause != GapCause::kStartedLate;
  if (block.kind != BlockKind::kEnd) {
    of.sum.add(crc_of(block));
  } else {
    of.ended = true;
    const EndBlock end = decode_end(block);
    if (of.all_its_own && end.blocks_crc32c != of.sum.crc32c())
      fault(header, "the end sums up other blocks than its node sealed");
    if (end.scans_sealed + end.scans_missing != of.truth->scans)
      fault(header, "the end counts " + std::to_string(end.scans_sealed + end.scans_missing) + " of " +
                        std::to_string(of.truth->scans) + " scans");
  }
}

// A gap that the recorder declares; any other block that no node sealed is a forgery.
void RecordCheck::take_declared(const SealedBlock& block, Seen& of) {
  of.all_its_own = false;
  const BlockHeader& header = block.header;
  if (block.kind != BlockKind::kGap) return fault(header, "is not as its node sealed it");
  ++declared_gaps_;
  const GapCause cause = decode_gap(block).cause;
  if (cause != GapCause::kLostAtNode && cause != GapCause::kNodeCrash)
    return fault(header, "declares what only a node can");
  if (header.sequence <= of.sequence) return fault(header, "a declared gap is there twice or out of order");
  const auto declared = of.said.declared.find(header.sequence);
  if (declared == of.said.declared.end()) return fault(header, "is a gap that no recorder declared");
  if (declared->second.promised > of.sequence)
    fault(header,
          "declares lost what was called durable through " + std::to_string(declared->second.promised));
  if (cause == GapCause::kNodeCrash) {
    if (header.sequence != of.sequence + 1) fault(header, "a crash is declared out of sequence");
    if (!of.truth->killed && !of.truth->gone) fault(header, "declares the crash of a node that lives");
    of.crashed = true;
    of.sequence = header.sequence;
    return;
  }
  if (declared->second.released < header.sequence && !declared->second.may_lack_more)
    fault(header, "is declared lost; its node may have given back those through " +
                      std::to_string(declared->second.released) + " only");
  of.sequence = header.sequence;
  take_scans(block, of);
  of.is_next_known = header.scans > 0;
}

void RecordCheck::take_scans(const SealedBlock& block, Seen& of) {
  if (block.kind == BlockKind::kScan) {
    run_on(block.header, of);
    check_samples(decode_scan(block), of.samples);
  } else if (block.kind == BlockKind::kGap) {
    run_on(block.header, of);
    declared_scans_ += block.header.scans;
  } else if (block.kind == BlockKind::kEnd) {
    run_on(block.header, of);
  }
}

void RecordCheck::run_on(const BlockHeader& header, Seen& of) {
  const std::int64_t missing = std::max<std::int64_t>(0, header.first_scan - of.next_scan);
  if (!std::exchange(of.is_next_known, true) && header.first_scan >= of.next_scan) {
    declared_scans_ += missing;
  } else if (header.first_scan != of.next_scan) {
    lost_scans_ += missing;
    fault(header, "begins with scan " + std::to_string(header.first_scan) + " instead of " +
                      std::to_string(of.next_scan));
  }
  of.next_scan = header.first_scan + header.scans;
}

void RecordCheck::check_samples(const ScanBlock& block, const HashedScans& samples) {
  std::array<HashedScans::Row, kScansPerBlock> truth;
  const auto rows = static_cast<std::size_t>(block.header.scans);
  samples.fill(block.header.first_scan, std::span(truth).first(rows));
  for (std::size_t row = 0; row < rows; ++row)
    if (!std::equal(truth[row].begin(), truth[row].end(), block.counts[row].begin()))
      fault(block.header, "samples of row " + std::to_string(row) + " are altered");
}

bool RecordCheck::is_closed(std::int32_t node, std::int64_t epoch) const {
  const auto found = seen_.find({node, epoch});
  return found != seen_.end() && (found->second.ended || found->second.crashed);
}

const RecordCheck::Said* RecordCheck::said(std::int32_t node, std::int64_t epoch) const {
  const auto found = seen_.find({node, epoch});
  return found == seen_.end() ? nullptr : &found->second.said;
}

std::int64_t RecordCheck::checked(std::int32_t node, std::int64_t epoch) const {
  const auto found = seen_.find({node, epoch});
  return found == seen_.end() ? 0 : found->second.sequence;
}

void RecordCheck::finish(bool closed) {
  for (const auto& [key, epoch] : truth_.epochs())
    if (epoch.scans > 0) seen(key);
  for (auto& [key, of] : seen_)
    if (of.truth && (of.truth->next() > 1 || of.sequence > 0)) finish(of, closed);  // else nothing was sealed
}

void RecordCheck::finish(Seen& of, bool closed) {
  const EpochTruth& epoch = *of.truth;
  const std::string name = "node " + std::to_string(epoch.node) + " epoch " + std::to_string(epoch.epoch);
  const std::int64_t missing = epoch.scans - of.next_scan;
  if (of.said.promised > of.sequence)
    truth_.fault(name + ": called durable through " + std::to_string(of.said.promised) +
                 ", recorded through " + std::to_string(of.sequence));
  if (of.ended && !of.crashed) {
    if (missing != 0) truth_.fault(name + ": " + std::to_string(missing) + " scans lie behind its end");
  } else if (of.crashed || (epoch.killed && of.sequence == 0)) {
    crash_tail_scans_ += missing;  // it died before the recorder had anything of it, or with a declared tail
  } else if (closed) {
    lost_scans_ += missing;
    truth_.fault(name + ": the record was closed without its end or crash; " + std::to_string(missing) +
                 " scans behind block " + std::to_string(of.sequence) + " are missing");
  }
}

}  // namespace roadbalance::test
