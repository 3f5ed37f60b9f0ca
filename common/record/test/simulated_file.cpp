#include "common/record/test/simulated_file.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace roadbalance::test {
namespace {

constexpr std::uint64_t kPageBytes = 4096;

std::uint64_t round_up(std::uint64_t value, std::uint64_t unit) {
  return (value + unit - 1) / unit * unit;
}

bool coin(std::mt19937_64& random) {
  return (random() >> 40 & 1) != 0;
}

}  // namespace

SimulatedFile::SimulatedFile(std::shared_ptr<std::int64_t> used_bytes) : used_bytes_(std::move(used_bytes)) {}

SimulatedFile::~SimulatedFile() {
  *used_bytes_ -= accounted_bytes_;
}

std::int64_t SimulatedFile::space_for(std::uint64_t size) const {
  return static_cast<std::int64_t>(round_up(std::max(size, reserved_), kPageBytes));
}

void SimulatedFile::account() {
  *used_bytes_ += space_for(size_) - accounted_bytes_;
  accounted_bytes_ = space_for(size_);
}

void SimulatedFile::set_size(std::uint64_t size) {
  size_ = size;
  while (chunks_.size() * kChunkBytes < size)
    chunks_.push_back(std::make_unique_for_overwrite<std::uint8_t[]>(kChunkBytes));
  chunks_.resize(round_up(size, kChunkBytes) / kChunkBytes);
  account();
}

void SimulatedFile::reserve(std::uint64_t size) {
  reserved_ = std::max(reserved_, size);
  account();
}

std::size_t SimulatedFile::read(std::uint64_t offset, std::span<std::uint8_t> into) const {
  const std::uint64_t end = std::min(size_, offset + into.size());
  std::size_t done = 0;
  while (offset < end) {
    const std::uint64_t part = std::min(end - offset, kChunkBytes - offset % kChunkBytes);
    std::memcpy(into.data() + done, chunks_[offset / kChunkBytes].get() + offset % kChunkBytes, part);
    done += part;
    offset += part;
  }
  return done;
}

// Within size_.
void SimulatedFile::put(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const std::uint64_t part = std::min<std::uint64_t>(bytes.size(), kChunkBytes - offset % kChunkBytes);
    std::memcpy(chunks_[offset / kChunkBytes].get() + offset % kChunkBytes, bytes.data(), part);
    bytes = bytes.subspan(part);
    offset += part;
  }
}

void SimulatedFile::put_zeros(std::uint64_t from, std::uint64_t to) {
  static constexpr Sector kZeros{};
  for (; from < to; from += std::min(to - from, kSectorBytes))
    put(from, {kZeros.data(), std::min(to - from, kSectorBytes)});
}

void SimulatedFile::write(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return;
  const std::uint64_t before = size_;
  const std::uint64_t end = offset + bytes.size();
  keep_old(offset, std::min(end, platter_size_));
  if (end > size_) set_size(end);
  put_zeros(before, offset);
  put(offset, bytes);
  mark_dirty(std::min(offset, before) / kSectorBytes, round_up(end, kSectorBytes) / kSectorBytes);
}

void SimulatedFile::resize(std::uint64_t size) {
  const std::uint64_t before = size_;
  keep_old(std::min(size, platter_size_), platter_size_);
  reserved_ = 0;
  set_size(size);
  put_zeros(before, size);
  if (size > before) mark_dirty(before / kSectorBytes, round_up(size, kSectorBytes) / kSectorBytes);
}

// The platter's content of this sector, unless old_ has it.
SimulatedFile::Sector SimulatedFile::platter_sector(std::uint64_t sector) const {
  Sector bytes{};
  const std::uint64_t from = sector * kSectorBytes;
  if (from < platter_size_) read(from, {bytes.data(), std::min(kSectorBytes, platter_size_ - from)});
  return bytes;
}

// Before bytes of the platter's length are written over.
void SimulatedFile::keep_old(std::uint64_t from, std::uint64_t to) {
  if (from >= to) return;
  for (std::uint64_t sector = from / kSectorBytes; sector * kSectorBytes < to; ++sector) {
    const auto [kept, is_new] = old_.try_emplace(sector);
    if (is_new) kept->second.bytes = platter_sector(sector);
    kept->second.lost = false;
  }
}

void SimulatedFile::mark_dirty(std::uint64_t from, std::uint64_t to) {
  // A lost sector written again may now reach the platter.
  for (auto kept = old_.lower_bound(from); kept != old_.end() && kept->first < to; ++kept)
    kept->second.lost = false;
  auto next = dirty_.upper_bound(from);
  if (next != dirty_.begin()) {
    const auto before = std::prev(next);
    if (before->second >= from) {
      from = before->first;
      to = std::max(to, before->second);
      next = dirty_.erase(before);
    }
  }
  while (next != dirty_.end() && next->first <= to) {
    to = std::max(to, next->second);
    next = dirty_.erase(next);
  }
  dirty_.emplace(from, to);
}

void SimulatedFile::sync() {
  dirty_.clear();
  std::erase_if(old_, [](const auto& kept) { return !kept.second.lost; });
  platter_size_ = size_;
}

void SimulatedFile::fail_sync(std::mt19937_64& random) {
  for (const auto& [from, to] : dirty_)
    for (std::uint64_t sector = from; sector < to; ++sector) {
      if (coin(random)) continue;  // this one got there
      const auto [kept, is_new] = old_.try_emplace(sector);
      if (is_new) kept->second.bytes = platter_sector(sector);
      kept->second.lost = true;
    }
  dirty_.clear();
  std::erase_if(old_, [this](const auto& kept) {
    return !kept.second.lost && kept.first * kSectorBytes < size_;  // those cut off await their sync
  });
}

std::uint64_t SimulatedFile::size_after_power_cut(std::mt19937_64& random) const {
  if (size_ <= platter_size_) return coin(random) ? size_ : platter_size_;
  switch (random() >> 40 & 3) {
    case 0:
      return size_;
    case 1:
      return platter_size_ + random() % (size_ - platter_size_ + 1);
    default:
      return platter_size_;
  }
}

// The sector was not synced and did not get there: it is as before, or, behind the old end, whatever lay
// there.  @return whether that is something else than was written
bool SimulatedFile::tear(std::uint64_t sector, std::mt19937_64& random) {
  const std::uint64_t from = sector * kSectorBytes;
  if (from >= size_) return false;
  const auto kept = old_.find(sector);
  Sector bytes = kept != old_.end() ? kept->second.bytes : platter_sector(sector);
  if (from >= platter_size_ && (random() >> 40 & 7) == 0)
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random() >> 40);
  const std::span<const std::uint8_t> torn(bytes.data(), std::min(kSectorBytes, size_ - from));
  Sector written{};
  read(from, {written.data(), torn.size()});
  put(from, torn);
  return !std::equal(torn.begin(), torn.end(), written.begin());
}

std::int64_t SimulatedFile::lose_power(std::mt19937_64& random) {
  const std::uint64_t cut_back = size_;
  const std::uint64_t size = size_after_power_cut(random);
  std::int64_t torn = 0;
  const auto tear = [&](std::uint64_t sector) {
    if (this->tear(sector, random) && sector * kSectorBytes < size) ++torn;
  };
  set_size(std::max(size, size_));
  for (const auto& [from, to] : dirty_) {
    const std::uint64_t one_in =
        random() >> 40 & 3;  // 0: nothing got there; else one sector in so many is missing
    for (std::uint64_t sector = from; sector < to; ++sector)
      if (one_in == 0 || (random() >> 40) % (4 * one_in) == 0) tear(sector);
  }
  for (const auto& [sector, kept] : old_)
    if (kept.lost || sector * kSectorBytes >= cut_back) tear(sector);
  // The sector that a cut goes through has its old end again if the cut is undone.
  if (size > cut_back && old_.contains(cut_back / kSectorBytes)) tear(cut_back / kSectorBytes);
  set_size(size);
  reserved_ = 0;
  account();
  dirty_.clear();
  old_.clear();
  platter_size_ = size_;
  return torn;
}

void SimulatedFile::damage(std::uint64_t offset, std::uint8_t flipped_bits) {
  chunks_[offset / kChunkBytes][offset % kChunkBytes] ^= flipped_bits;
}

}  // namespace roadbalance::test
