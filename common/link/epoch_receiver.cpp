#include "common/link/epoch_receiver.hpp"

#include <algorithm>

namespace roadbalance {
namespace {

// A loss waits for a block that says which scan comes next, but not for more blocks than these.
constexpr std::int64_t kMostBlocksHeld = 64;

bool tells_scan(const SealedBlock& block) {
  return block.kind == BlockKind::kScan || block.kind == BlockKind::kGap || block.kind == BlockKind::kEnd;
}

}  // namespace

EpochReceiver::EpochReceiver(std::int32_t node, std::int64_t epoch, EpochPosition start,
                             ReceiverOptions options)
    : node_(node),
      epoch_(epoch),
      options_(options),
      slots_(static_cast<std::size_t>(options.window)),
      contiguous_(start.contiguous),
      durable_(start.contiguous),
      highest_(start.contiguous),
      newest_arrived_(start.contiguous),
      ended_(start.ended),
      next_scan_(start.next_scan) {}

EpochReceiver::Slot& EpochReceiver::slot(std::int64_t sequence) {
  return slots_[static_cast<std::size_t>(sequence % options_.window)];
}

std::int64_t EpochReceiver::credit() const {
  return std::max(contiguous_, std::min(contiguous_ + options_.window, durable_ + options_.undurable));
}

void EpochReceiver::durable(std::int64_t sequence) {
  durable_ = std::max(durable_, std::min(sequence, contiguous_));
}

void EpochReceiver::extend(std::int64_t sequence, WallTime now) {
  while (highest_ < sequence) {
    Slot& s = slot(++highest_);
    s.arrived = s.asked = false;
    s.noticed = now;
  }
}

EpochReceiver::Take EpochReceiver::block(const SealedBlock& block, WallTime now, std::vector<Delivery>& out) {
  const std::int64_t sequence = block.header.sequence;
  if (sequence <= contiguous_) return Take::kDuplicate;
  if (sequence > contiguous_ + options_.window) return Take::kOutsideWindow;
  extend(sequence, now);
  Slot& s = slot(sequence);
  if (s.arrived) return Take::kDuplicate;
  s.block = block;
  s.arrived = true;
  newest_arrived_ = std::max(newest_arrived_, sequence);
  deliver_contiguous(out);
  return Take::kAccepted;
}

void EpochReceiver::heartbeat(const Heartbeat& heartbeat, WallTime now, std::vector<Delivery>& out) {
  if (heartbeat.base > contiguous_ + 1) lose_through(heartbeat.base - 1, out);
  extend(std::min(heartbeat.next - 1, credit()), now);
}

void EpochReceiver::deliver(Slot& s, std::vector<Delivery>& out) {
  const SealedBlock& block = s.block;
  if (tells_scan(block)) {
    const std::int64_t since = block.header.first_scan - last_scans_.first_scan;
    if (last_scans_.sequence > 0 && since > 0)
      ns_per_scan_ =
          static_cast<double>(block.header.time_ns - last_scans_.time_ns) / static_cast<double>(since);
    next_scan_ = block.header.first_scan + block.header.scans;
    last_scans_ = block.header;
  }
  ended_ = ended_ || block.kind == BlockKind::kEnd;
  out.emplace_back(block);
  s.arrived = false;
  ++contiguous_;
}

void EpochReceiver::deliver_contiguous(std::vector<Delivery>& out) {
  if (loss_through_ > 0 && !declare_loss(out, false)) return;
  while (contiguous_ < highest_ && slot(contiguous_ + 1).arrived) deliver(slot(contiguous_ + 1), out);
}

// The blocks through loss_through_ are gone.  How many scans they held is told by the next block that has a
// scan index; until it is there nothing is delivered.
bool EpochReceiver::declare_loss(std::vector<Delivery>& out, bool at_once) {
  const std::int64_t behind = loss_through_ + 1;
  std::int64_t at = behind;
  while (at <= highest_ && slot(at).arrived && !tells_scan(slot(at).block)) ++at;
  const bool told = at <= highest_ && slot(at).arrived;
  if (!told && !at_once && at - behind < kMostBlocksHeld) return false;

  GapBlock gap;
  gap.cause = GapCause::kLostAtNode;
  gap.header = next_header(loss_through_);
  if (told) {
    const BlockHeader& after = slot(at).block.header;
    gap.header.scans = std::max<std::int64_t>(0, after.first_scan - next_scan_);
    // The instant of the first lost scan lies on the line through the blocks before and after.
    const auto span_scans = static_cast<double>(after.first_scan - last_scans_.first_scan);
    if (span_scans > 0 && last_scans_.sequence > 0)
      gap.header.time_ns =
          last_scans_.time_ns +
          static_cast<std::int64_t>(static_cast<double>(after.time_ns - last_scans_.time_ns) *
                                    static_cast<double>(last_scans_.scans) / span_scans);
    else
      gap.header.time_ns = after.time_ns;
    next_scan_ = after.first_scan;
  }
  out.emplace_back(gap);
  ++gaps_;
  loss_through_ = 0;
  return true;
}

// Of a declared gap.  Its instant is where the time between the last two blocks with scans leads.
BlockHeader EpochReceiver::next_header(std::int64_t sequence) const {
  const double scans_since = static_cast<double>(next_scan_ - last_scans_.first_scan);
  return {.node = node_,
          .epoch = epoch_,
          .sequence = sequence,
          .first_scan = next_scan_,
          .time_ns = last_scans_.time_ns + static_cast<std::int64_t>(scans_since * ns_per_scan_)};
}

void EpochReceiver::lose_through(std::int64_t sequence, std::vector<Delivery>& out) {
  while (contiguous_ < sequence) {
    if (contiguous_ < highest_ && slot(contiguous_ + 1).arrived) {
      if (loss_through_ > 0) declare_loss(out, true);
      deliver(slot(contiguous_ + 1), out);
    } else if (contiguous_ < highest_) {
      loss_through_ = ++contiguous_;
    } else {
      loss_through_ = contiguous_ = sequence;
    }
  }
  highest_ = std::max(highest_, contiguous_);
  deliver_contiguous(out);
}

void EpochReceiver::crash(std::vector<Delivery>& out) {
  if (ended_) return;
  lose_through(newest_arrived_, out);
  if (loss_through_ > 0) declare_loss(out, true);
  deliver_contiguous(out);
  if (ended_) return;  // the end was among what had arrived
  GapBlock gap;
  gap.cause = GapCause::kNodeCrash;
  gap.header = next_header(++contiguous_);
  out.emplace_back(gap);
  ++gaps_;
  ended_ = true;
}

std::vector<SequenceRange> EpochReceiver::missing(WallTime now) {
  std::vector<SequenceRange> ranges;
  for (std::int64_t k = contiguous_ + 1; k <= highest_; ++k) {
    Slot& s = slot(k);
    if (s.arrived) continue;
    const bool is_hole = now - s.noticed >= options_.hole_age || newest_arrived_ >= k + options_.newer_blocks;
    if (!is_hole || (s.asked && now - s.asked_at < options_.ask_again)) continue;
    const bool continues = !ranges.empty() && ranges.back().last == k - 1;
    if (!continues && ranges.size() == kMaxMissingRanges) break;
    if (continues)
      ranges.back().last = k;
    else
      ranges.push_back({k, k});
    s.asked = true;
    s.asked_at = now;
  }
  return ranges;
}

}  // namespace roadbalance
