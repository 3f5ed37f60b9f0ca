#include "common/link/epoch_receiver.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "common/link/planted.hpp"

namespace roadbalance {
namespace {

// A loss waits for a block that shows which scan comes next, but not for more blocks than these.
constexpr std::int64_t kMostBlocksHeld = 64;

// Nor for longer: blocks that are held behind it, and are not durable, keep their node from giving up the
// block that would show it.  After a wait in vain it waits for the next heartbeat only, for a while: from a
// disk that is gone nothing comes, and there may be thousands.
constexpr std::chrono::milliseconds kLongestWait{2000}, kNextWait{50};
constexpr std::chrono::seconds kNextWaits{10};

// A crash that ends an epoch has the number behind all of its blocks.
constexpr std::int64_t kLastSequence = kIndexLimit - 1;

}  // namespace

EpochReceiver::EpochReceiver(std::int32_t node, std::int64_t epoch, EpochPosition start,
                             ReceiverOptions options)
    : node_(node),
      epoch_(epoch),
      options_(options),
      slots_(static_cast<std::size_t>(options.window)),
      ask_interval_(options.ask_again),
      contiguous_(start.contiguous),
      durable_(start.contiguous),
      highest_(start.contiguous),
      newest_arrived_(start.contiguous),
      credit_given_(start.contiguous),
      ended_(start.ended),
      given_up_(start.crashed),
      received_at_crash_(start.crashed ? 0 : start.contiguous),
      next_scan_(start.next_scan) {}

EpochReceiver::Slot& EpochReceiver::slot(std::int64_t sequence) {
  return slots_[static_cast<std::size_t>(sequence % options_.window)];
}

SealedBlock& EpochReceiver::stored(std::int64_t sequence) {
  return blocks_[static_cast<std::size_t>(sequence % options_.window)];
}

EpochPosition EpochReceiver::position() const {
  return {.contiguous = contiguous_, .next_scan = next_scan_, .ended = ended_, .crashed = given_up_};
}

void EpochReceiver::check() const {
  assert(durable_ <= contiguous_ && contiguous_ <= highest_ && highest_ <= contiguous_ + options_.window);
  assert(!has_holes() || newest_arrived_ <= highest_);
}

std::int64_t EpochReceiver::credit() const {
  if (given_up_) return received_at_crash_;
  if (!credit_open_) return std::max(contiguous_, credit_given_);
  return std::max(contiguous_, most());
}

// Blocks that are lost take no memory, and what ends a loss must be let in before it can become durable.
std::int64_t EpochReceiver::most() const {
  return std::min(
      {contiguous_ + options_.window, std::max(durable_, lost_through_) + options_.undurable, kLastSequence});
}

void EpochReceiver::set_credit_open(bool open) {
  credit_open_ = open;
}

void EpochReceiver::durable(std::int64_t sequence) {
  durable_ = std::max(durable_, std::min(sequence, contiguous_));
}

void EpochReceiver::extend(std::int64_t sequence, WallTime now) {
  while (highest_ < sequence) slot(++highest_) = {.noticed = now, .asked_at = {}};
}

// Blocks that came before, in or out of order.  Its slot still holds how often it was asked for if no other
// block has taken it.
EpochReceiver::Take EpochReceiver::repeated(const SealedBlock& block, std::vector<Delivery>& out) {
  const std::int64_t sequence = block.header.sequence;
  if (highest_ < sequence + options_.window && slot(sequence).asks > 1) ask_interval_.answered_twice();
  if (planted(PlantedFault::kNoDeduplication)) out.emplace_back(block);
  return Take::kDuplicate;
}

void EpochReceiver::answered(Slot& s, WallTime now) {
  if (s.asks == 1)
    ask_interval_.answered_once(now - s.asked_at);
  else if (s.asks > 1)
    ask_interval_.answered_late();
}

EpochReceiver::Take EpochReceiver::block(const SealedBlock& block, WallTime now, std::vector<Delivery>& out) {
  const std::int64_t sequence = block.header.sequence;
  if (sequence <= contiguous_) return repeated(block, out);
  if (ended_ || sequence > most()) return Take::kOutsideWindow;
  extend(sequence, now);
  Slot& s = slot(sequence);
  if (s.arrived) return repeated(block, out);
  answered(s, now);
  newest_arrived_ = std::max(newest_arrived_, sequence);
  if (sequence == contiguous_ + 1 && loss_through_ == 0) {
    deliver(block, out);  // in order, the common case: no other copy
  } else {
    if (blocks_.empty()) blocks_.resize(slots_.size());
    stored(sequence) = block;
    s.arrived = true;
  }
  deliver_contiguous(out);
  check();
  return Take::kAccepted;
}

void EpochReceiver::heartbeat(const Heartbeat& heartbeat, WallTime now, std::vector<Delivery>& out) {
  if (ended_) return;
  const std::int64_t gone = planted(PlantedFault::kOneTooManyLost)
                                ? std::min(heartbeat.base, heartbeat.next - 1)
                                : heartbeat.base - 1;
  if (heartbeat.base > contiguous_ + 1) lose_through(gone, out);
  if (heartbeat.is_over() && loss_through_ > 0 && loss_through_ == heartbeat.next - 1) {
    // The end went to another recorder; the number of scans is reported all the same.
    declare_loss(out, heartbeat.scans_sampled);
    ended_ = true;
  }
  wait_no_longer(now, out);
  if (!ended_ && !planted(PlantedFault::kNoHeartbeat))
    extend(std::min({heartbeat.next - 1, credit_given_, contiguous_ + options_.window}), now);
  check();
}

void EpochReceiver::deliver(const SealedBlock& block, std::vector<Delivery>& out) {
  scan_line_.take(block.kind, block.header);
  if (ScanLine::carries_scan(block.kind)) next_scan_ = block.header.first_scan + block.header.scans;
  ended_ = ended_ || block.kind == BlockKind::kEnd;
  out.emplace_back(std::in_place_type<SealedBlock>, block);
  ++contiguous_;
  slot(contiguous_).arrived = false;
}

void EpochReceiver::deliver_contiguous(std::vector<Delivery>& out) {
  if (loss_through_ > 0 && !declare_loss(out, std::nullopt)) return;
  while (contiguous_ < highest_ && slot(contiguous_ + 1).arrived) deliver(stored(contiguous_ + 1), out);
}

// The blocks through loss_through_ are gone.  The next block that has a scan index shows how many scans they
// held; until it is there nothing is delivered, unless the caller gives the number of the next scan.
bool EpochReceiver::declare_loss(std::vector<Delivery>& out, std::optional<std::int64_t> next_scan) {
  const std::int64_t behind = loss_through_ + 1;
  std::int64_t at = behind;
  while (at <= highest_ && slot(at).arrived && !ScanLine::carries_scan(stored(at).kind)) ++at;
  const bool is_placed = at <= highest_ && slot(at).arrived;
  if (!is_placed && !next_scan && at - behind < kMostBlocksHeld) return false;

  GapBlock gap;
  gap.cause = GapCause::kLostAtNode;
  const BlockHeader* const after = is_placed ? &stored(at).header : nullptr;
  gap.header = next_header(loss_through_, after);
  if (after) {
    gap.header.scans = std::max<std::int64_t>(0, after->first_scan - next_scan_);
    next_scan_ = after->first_scan;
  } else if (next_scan) {
    gap.header.scans = std::max<std::int64_t>(0, *next_scan - next_scan_);
    next_scan_ += gap.header.scans;
  }
  loss_through_ = 0;
  waits_since_.reset();
  if (planted(PlantedFault::kLostDeclaredLate)) return true;
  out.emplace_back(gap);
  ++gaps_;
  return true;
}

// The gap has no scans then; the next one, or a jump of the scans, shows how many are missing in both.
void EpochReceiver::wait_no_longer(WallTime now, std::vector<Delivery>& out) {
  if (loss_through_ == 0) return;
  if (!waits_since_) waits_since_ = now;
  const bool holds_up = loss_through_ < highest_ && slot(loss_through_ + 1).arrived;
  const bool waits_briefly = waited_at_ && now - *waited_at_ < kNextWaits;
  if (!holds_up || now - *waits_since_ < (waits_briefly ? kNextWait : kLongestWait)) return;
  waited_at_ = now;
  declare_loss(out, next_scan_);
  deliver_contiguous(out);
}

// For a declared gap, with the next block that shows its scan, if there is one.
BlockHeader EpochReceiver::next_header(std::int64_t sequence, const BlockHeader* after) const {
  return {.node = node_,
          .epoch = epoch_,
          .sequence = sequence,
          .first_scan = next_scan_,
          .time_ns = scan_line_.time_ns(next_scan_, after).value_or(0)};
}

void EpochReceiver::lose_through(std::int64_t sequence, std::vector<Delivery>& out) {
  while (contiguous_ < sequence) {
    if (contiguous_ < highest_ && slot(contiguous_ + 1).arrived) {
      if (loss_through_ > 0) declare_loss(out, next_scan_);
      deliver(stored(contiguous_ + 1), out);
    } else if (contiguous_ < highest_) {
      lost_through_ = loss_through_ = ++contiguous_;
    } else {
      lost_through_ = loss_through_ = contiguous_ = sequence;
    }
  }
  highest_ = std::max(highest_, contiguous_);
  deliver_contiguous(out);
}

void EpochReceiver::crash(std::vector<Delivery>& out) {
  if (ended_) return;
  given_up_ = true;
  received_at_crash_ = contiguous_;
  // Behind a hole an end would mean that all is well: the crash takes its number.  One with blocks behind it
  // is no end that this node sealed.
  bool has_end = false;
  for (std::int64_t k = contiguous_ + 1; has_holes() && k <= newest_arrived_; ++k) {
    if (!slot(k).arrived || stored(k).kind != BlockKind::kEnd) continue;
    slot(k).arrived = false;
    has_end = k == newest_arrived_;
  }
  lose_through(has_end ? newest_arrived_ - 1 : newest_arrived_, out);
  if (loss_through_ > 0) declare_loss(out, next_scan_);
  deliver_contiguous(out);
  assert(!ended_);
  ended_ = true;
  highest_ = newest_arrived_ = contiguous_ + 1;
  GapBlock gap;
  gap.cause = GapCause::kNodeCrash;
  gap.header = next_header(++contiguous_, nullptr);
  std::vector<SealedBlock>().swap(blocks_);
  check();
  if (planted(PlantedFault::kNoCrashGap)) return;
  out.emplace_back(gap);
  ++gaps_;
}

bool EpochReceiver::is_asked_now(Slot& s, std::int64_t sequence, WallTime now) {
  const bool was_sent = newest_arrived_ > sequence;
  if (s.asks == 0) {
    if (now - s.noticed < options_.hole_age && newest_arrived_ < sequence + options_.newer_blocks)
      return false;
  } else if (now - s.asked_at < ask_interval_.get()) {
    return !std::exchange(s.reported_twice, s.reported_twice || now - s.asked_at >= options_.repeat_after) &&
           s.reported_twice;
  }
  // For a block that may not have been sent yet the first answer does not measure the round trip.
  s.asks += was_sent ? 1 : 2;
  s.asked_at = now;
  s.reported_twice = false;
  return true;
}

std::vector<SequenceRange> EpochReceiver::missing(WallTime now) {
  std::vector<SequenceRange> ranges;
  if (ended_) return ranges;
  // Often and through the whole window, so without dividing for each.
  auto next = slots_.begin() + (contiguous_ + 1) % options_.window;
  for (std::int64_t k = contiguous_ + 1; k <= highest_; ++k) {
    Slot& s = *next;
    if (++next == slots_.end()) next = slots_.begin();
    if (s.arrived) continue;
    const bool continues = !ranges.empty() && ranges.back().last == k - 1;
    if (!continues && ranges.size() == kMaxMissingRanges) break;
    if (!is_asked_now(s, k, now)) continue;
    if (continues)
      ranges.back().last = k;
    else
      ranges.push_back({k, k});
  }
  return ranges;
}

Ack EpochReceiver::acknowledge(WallTime now) {
  const std::int64_t received = given_up_ ? received_at_crash_ : contiguous_;
  credit_given_ = std::max(credit_given_, credit());
  return {.node = node_,
          .epoch = epoch_,
          .incarnation = 0,
          .number = 0,
          .received = received,
          .durable = std::min(durable_, received),
          .credit = std::max(received, credit()),
          .missing = missing(now)};
}

}  // namespace roadbalance
