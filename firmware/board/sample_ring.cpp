#include "firmware/board/sample_ring.hpp"

namespace roadbalance::board {
namespace {

constexpr std::uint32_t kWordMask = 0xFFFFFF;
constexpr std::uint32_t kHighestWord = 0x7FFFFF;
constexpr std::uint32_t kLowestWord = 0x800000;

std::uint16_t at_limit(const ScanWords& words, std::size_t channels) {
  std::uint32_t bits = 0;
  for (std::size_t channel = 0; channel < channels; ++channel) {
    const std::uint32_t word = words[channel] & kWordMask;
    if (word == kHighestWord || word == kLowestWord) bits |= 1u << channel;
  }
  return static_cast<std::uint16_t>(bits);
}

PacketScan counter_pattern(std::uint64_t index) {
  PacketScan scan;
  for (std::size_t channel = 0; channel < kStreamChannels; ++channel)
    scan.counts[channel] = static_cast<std::int32_t>((index * kStreamChannels + channel) & kWordMask);
  return scan;
}

}  // namespace

void SampleRing::start(const Setup& setup) {
  setup_ = setup;
  queue_.clear();
  first_ = true;
  index_ = 0;
  for (Counter* counter : {&lost_, &missed_, &overloads_, &glitches_}) counter->clear();
}

bool SampleRing::add(const ScanWords& words, std::uint16_t overload, std::uint64_t ticks) {
  if (!first_) {
    const std::uint64_t later = ticks - ticks_;
    if (later > std::uint64_t{kLongestHole} * setup_.ticks_per_scan) return false;
    // Below 2^32: the longest hole of the slowest rate is seconds of a timer of 100 MHz.
    const std::uint32_t periods =
        static_cast<std::uint32_t>(later + setup_.ticks_per_scan / 2) / setup_.ticks_per_scan;
    if (periods == 0) {
      glitches_.add();
      return true;
    }
    missed_.add(periods - 1);
    index_ += periods;
  }
  first_ = false;
  ticks_ = ticks;
  StoredScan* scan = queue_.room();
  if (scan == nullptr) {
    lost_.add();
    return true;
  }
  if (setup_.pattern == Pattern::kOff) overload |= at_limit(words, channels());
  if (overload != 0) overloads_.add();
  store(*scan, words, overload);
  queue_.publish();
  return true;
}

void SampleRing::store(StoredScan& scan, const ScanWords& words, std::uint16_t overload) const {
  scan.index = index_;
  scan.ticks = ticks_;
  PacketScan content;
  if (setup_.pattern == Pattern::kCounter) {
    content = counter_pattern(index_);
  } else {
    for (std::size_t k = 0; k < channels(); ++k) content.counts[k] = static_cast<std::int32_t>(words[k]);
  }
  content.overload = overload;
  encode_scan(content, scan.bytes);
}

}  // namespace roadbalance::board
