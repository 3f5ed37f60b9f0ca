#include "common/link/backlog.hpp"

#include <algorithm>
#include <cassert>

namespace roadbalance {
namespace {

// Moved at a time, as a share of the ring: few syncs, and none of them holds the link up for long.
constexpr std::int64_t kShareMoved = 16;

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
  if (spool_->read(sequence, block_)) return &block_;
  not_read(sequence);
  return nullptr;
}

void Backlog::not_read(std::int64_t sequence) {
  if (sequence != base()) return;
  tries_ = sequence == unread_ ? tries_ + 1 : 1;
  unread_ = sequence;
  if (tries_ >= kMostTries) free_through(sequence);
}

void Backlog::free_through(std::int64_t sequence) {
  assert(sequence < next());
  if (spool_ && spool_->base() < spool_->next()) spool_->free_through(std::min(sequence, spool_->next() - 1));
  if (sequence >= ring_.base()) ring_.free_through(sequence);
}

void Backlog::relieve(WallTime now) {
  if (!spool_ || ring_.used() * 2 <= ring_.capacity()) return;
  const std::int64_t first = ring_.base();
  const std::int64_t last = first + std::max<std::int64_t>(1, ring_.capacity() / kShareMoved) - 1;
  spool_->keep(ring_, first, std::min(last, ring_.next() - 1), now);
  if (spool_->base() == spool_->next()) return;
  assert(spool_->next() - 1 <= last);
  ring_.free_through(spool_->next() - 1);
  assert(spool_->next() == ring_.base());
}

}  // namespace roadbalance
