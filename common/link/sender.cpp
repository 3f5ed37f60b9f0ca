#include "common/link/sender.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "common/link/planted.hpp"

namespace roadbalance {
namespace {

// All that a recorder asks for lies within its window (2048 blocks), so that no two share a place.
constexpr std::size_t kSentRemembered = 4096;

}  // namespace

Sender::Sender(Backlog& backlog, std::int32_t node, std::int64_t epoch, Options options)
    : backlog_(backlog),
      node_(node),
      epoch_(epoch),
      options_(options),
      tokens_(options.burst_blocks),
      sent_(kSentRemembered) {
  due_.reserve(static_cast<std::size_t>(options.burst_blocks) + 1);
}

bool Sender::claim(std::int64_t incarnation, WallTime now) {
  if (incarnation != owner_) {
    const bool stale = incarnation < highest_owner_ && !planted(PlantedFault::kStaleRecorder);
    if (is_led(now) || stale) return false;
    if (incarnation != highest_owner_) {
      ack_number_ = 0;
      new_owner_ = true;
    }
    owner_ = incarnation;
    highest_owner_ = std::max(highest_owner_, incarnation);
    credit_ = 0;
    missing_count_ = 0;
  }
  owner_heard_ = now;
  return true;
}

bool Sender::release(std::int64_t incarnation) {
  if (owner_ == 0 || incarnation != owner_) return false;
  owner_ = 0;
  credit_ = 0;
  missing_count_ = 0;
  return true;
}

bool Sender::is_good(const Ack& ack) const {
  const bool obeyed = ack.incarnation == owner_ || planted(PlantedFault::kStaleRecorder);
  return ack.node == node_ && ack.epoch == epoch_ && owner_ != 0 && obeyed && ack.number > ack_number_ &&
         ack.durable < backlog_.next() && ack.durable <= ack.received &&
         ack.missing.size() <= kMaxMissingRanges;
}

bool Sender::take(const Ack& ack, WallTime now) {
  if (!is_good(ack)) {
    ++acks_refused_;
    return false;
  }
  ack_number_ = ack.number;
  owner_heard_ = now;
  credit_ = std::max(credit_, ack.credit);
  backlog_.free_through(planted(PlantedFault::kFreeOnReceive) ? ack.received : ack.durable);
  if (std::exchange(new_owner_, false)) sent_through_ = std::min(sent_through_, ack.received);
  check();
  // An ack without ranges asks for nothing new; blocks that the one before asked for may still wait for
  // tokens.
  if (ack.missing.empty()) return true;
  std::copy(ack.missing.begin(), ack.missing.end(), missing_.begin());
  missing_count_ = ack.missing.size();
  missing_at_ = 0;
  return true;
}

void Sender::check() const {
  assert(owner_ == 0 || owner_ == highest_owner_ || planted(PlantedFault::kStaleRecorder));
  assert(sent_through_ < backlog_.next() && backlog_.base() <= backlog_.next());
}

bool Sender::was_sent_lately(std::int64_t sequence, WallTime now) const {
  const Sent& sent = sent_[static_cast<std::size_t>(sequence) % kSentRemembered];
  return sent.sequence == sequence && now - sent.at < options_.repeat_after;
}

bool Sender::spend_token() {
  if (tokens_ < 1) return false;
  tokens_ -= 1;
  return true;
}

void Sender::send(std::int64_t sequence, WallTime now) {
  sent_[static_cast<std::size_t>(sequence) % kSentRemembered] = {sequence, now};
  due_.push_back(sequence);
  ++blocks_sent_;
}

// A block that was never sent is not repaired: it goes out as new, and would go twice.
void Sender::repair(WallTime now) {
  for (; missing_at_ < missing_count_; ++missing_at_) {
    SequenceRange& range = missing_[missing_at_];
    const std::int64_t last = std::min(range.last, sent_through_);
    range.first = std::max(range.first, backlog_.base());
    for (; range.first <= last; ++range.first) {
      if (was_sent_lately(range.first, now)) continue;
      if (!spend_token()) return;
      send(range.first, now);
      ++blocks_repaired_;
    }
  }
}

std::span<const std::int64_t> Sender::due(WallTime now) {
  due_.clear();
  const double seconds = std::chrono::duration<double>(now - tokens_at_).count();
  tokens_ = std::min(options_.burst_blocks, tokens_ + std::max(0.0, seconds) * options_.blocks_per_s);
  tokens_at_ = now;
  if (owner_ == 0) return due_;

  repair(now);
  // Blocks freed before they were sent came to the recorder through another recorder.
  sent_through_ = std::max(sent_through_, backlog_.base() - 1);
  const std::int64_t last = std::min(backlog_.next() - 1, credit_);
  // A new owner soon gets the blocks that the owner before got.
  while (sent_through_ < last && !was_sent_lately(sent_through_ + 1, now) && spend_token())
    send(++sent_through_, now);
  check();
  return due_;
}

}  // namespace roadbalance
