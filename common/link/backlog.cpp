#include "common/link/backlog.hpp"

#include <algorithm>
#include <cassert>

namespace roadbalance {
namespace {

// Moved at a time, as a share of the ring: few syncs, and none of them holds the link up for long.
constexpr std::int64_t kShareMoved = 16;
// In a row, at the end: the person who stops the node waits, and each may take as long as a disk does.
constexpr int kMostTriesToSave = 5;

}  // namespace

Backlog::Backlog(Ring& ring, Spool* spool) : ring_(ring), spool_(spool) {}

std::int64_t Backlog::base() const {
  return spool_ && spool_->base() < spool_->next() ? spool_->base() : ring_.base();
}

std::int64_t Backlog::capacity() const {
  return ring_.capacity() + (spool_ ? spool_->capacity() : 0);
}

std::int64_t Backlog::spooled() const {
  return spool_ ? spool_->next() - spool_->base() : 0;
}

std::int64_t Backlog::spool_failures() const {
  return spool_ ? spool_->failures() : 0;
}

const SealedBlock* Backlog::get(std::int64_t sequence) {
  assert(base() <= sequence && sequence < next());
  if (!is_spooled(sequence)) return &ring_.get(sequence);
  if (spool_->read(sequence, block_)) {
    gave_up_ = false;
    return &block_;
  }
  not_read(sequence);
  return nullptr;
}

void Backlog::not_read(std::int64_t sequence) {
  if (sequence != base()) return;
  tries_ = sequence == unread_ ? tries_ + 1 : 1;
  unread_ = sequence;
  if (!gave_up_ && tries_ % kMostTries != 0) return;
  if (spool_->answers()) {
    gave_up_ = true;
    spool_->give_up_through(sequence);
  } else if (!may_wait()) {
    spool_->give_up_through(spool_->next() - 1);
  }
}

// For a disk that is gone.  Blocks in the ring behind it reach no recorder until all of it is given up.
bool Backlog::may_wait() const {
  if (ring_.used() * 4 > ring_.capacity() * 3) return false;
  const bool is_over = ring_.used() > 0 && ring_.get(ring_.next() - 1).kind == BlockKind::kEnd;
  return !is_over || tries_ < kMostTriesAtEnd;
}

void Backlog::free_through(std::int64_t sequence) {
  assert(sequence < next());
  if (spool_ && spool_->base() < spool_->next()) spool_->free_through(std::min(sequence, spool_->next() - 1));
  if (sequence >= ring_.base()) ring_.free_through(sequence);
}

// An epoch begins with its description: nothing is freed before it was seen here.
void Backlog::describe() {
  for (; described_ >= 0 && described_ + 1 < ring_.next(); ++described_) {
    if (described_ + 1 < ring_.base() || ring_.get(described_ + 1).kind != BlockKind::kMeta) {
      described_ = -1;
      return;
    }
    spool_->describe(ring_.get(described_ + 1));
  }
}

void Backlog::move(std::int64_t blocks, WallTime now) {
  const std::int64_t first = ring_.base();
  spool_->keep(ring_, first, std::min(first + blocks, ring_.next()) - 1, now);
  if (spool_->base() < spool_->next()) ring_.free_through(spool_->next() - 1);
  assert(spool_->base() == spool_->next() || spool_->next() == ring_.base());
}

void Backlog::relieve(WallTime now) {
  if (!spool_) return;
  describe();
  if (ring_.used() * 2 > ring_.capacity())
    move(std::max<std::int64_t>(1, ring_.capacity() / kShareMoved), now);
}

void Backlog::save(WallTime now) {
  if (!spool_) return;
  describe();
  spool_->never_wait();
  std::int64_t blocks = ring_.used();
  for (int refused = 0; ring_.used() > 0 && refused < kMostTriesToSave;) {
    const std::int64_t before = ring_.base(), failures = spool_->failures();
    move(blocks, now);
    if (ring_.base() > before) {
      refused = 0;
    } else if (spool_->failures() > failures) {
      ++refused;
      blocks = std::max<std::int64_t>(1, blocks / 4);  // a disk that is nearly full takes a part
    } else {
      return;  // it is full
    }
  }
}

}  // namespace roadbalance
