#include "common/link/ring.hpp"

#include <cassert>
#include <stdexcept>
#include <string>

namespace roadbalance {

Ring::Ring(std::size_t bytes) {
  const std::size_t slots = bytes / sizeof(SealedBlock);
  if (slots < 16)
    throw std::invalid_argument("ring of " + std::to_string(bytes) + " bytes: at least " +
                                std::to_string(16 * sizeof(SealedBlock)) + " are needed");
  slots_.resize(slots);
}

std::int64_t Ring::used() const {
  // base first: next only grows, so a third thread never sees a negative number.
  const std::int64_t oldest = base();
  return next() - oldest;
}

SealedBlock* Ring::claim() {
  const std::int64_t sequence = next_.load(std::memory_order_relaxed);
  if (sequence - base_.load(std::memory_order_acquire) >= capacity()) return nullptr;
  return &slots_[static_cast<std::size_t>(sequence % capacity())];
}

void Ring::commit() {
  const std::int64_t sequence = next_.load(std::memory_order_relaxed);
  assert(slots_[static_cast<std::size_t>(sequence % capacity())].header.sequence == sequence);
  next_.store(sequence + 1, std::memory_order_release);
}

const SealedBlock& Ring::get(std::int64_t sequence) const {
  assert(sequence >= base() && sequence < next());
  return slots_[static_cast<std::size_t>(sequence % capacity())];
}

void Ring::free_through(std::int64_t sequence) {
  assert(sequence < next());
  if (sequence >= base_.load(std::memory_order_relaxed)) base_.store(sequence + 1, std::memory_order_release);
}

}  // namespace roadbalance
