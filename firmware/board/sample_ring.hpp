#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/board/counter.hpp"
#include "firmware/board/interrupt_ring.hpp"
#include "firmware/board/packet.hpp"

namespace roadbalance::board {

/// The converters' words of one scan: two's complement in the low 24 bits.
using ScanWords = std::array<std::uint32_t, kStreamChannels>;

struct StoredScan {
  std::uint64_t index = 0;
  std::uint64_t ticks = 0;
  std::array<std::uint8_t, kScanBytes> bytes{};  ///< as in the packet
};

/// Scans between the conversion and the USB: 2048, i.e. 205 ms at 10 kHz.
///
/// Gives each conversion its index by its time, so that one that did not come leaves a hole, and a full ring,
/// too.
class SampleRing {
 public:
  static constexpr std::size_t kScans = 2048;

  /// A hole longer than this (in periods) cannot be counted: 2500 periods at 100 ppm are a quarter of one.
  static constexpr std::uint32_t kLongestHole = 2500;

  struct Setup {
    std::uint32_t ticks_per_scan = 1;
    bool loop_back = false;  ///< else the loop-back channels are 0
    Pattern pattern = Pattern::kOff;
  };
  /// Begins a run; while no interrupt comes.
  void start(const Setup& setup);

  /// Interrupt: one conversion.  False if the hole before it is too long: its index is unknown, nothing is
  /// stored.
  /// @param overload  bit k: set by the analogue part of channel k; a word at its limit sets it, too
  [[nodiscard]] bool add(const ScanWords& words, std::uint16_t overload, std::uint64_t ticks);

  /// Main loop's end.
  InterruptRing<StoredScan, kScans>& queue() { return queue_; }

  std::uint32_t lost() const { return lost_.value(); }
  std::uint32_t missed() const { return missed_.value(); }
  std::uint32_t overloads() const { return overloads_.value(); }
  std::uint32_t glitches() const { return glitches_.value(); }

 private:
  std::size_t channels() const { return setup_.loop_back ? kStreamChannels : kInputChannels; }
  void store(StoredScan& scan, const ScanWords& words, std::uint16_t overload) const;

  Setup setup_;
  InterruptRing<StoredScan, kScans> queue_;
  bool first_ = true;
  std::uint64_t index_ = 0;  ///< of the last conversion
  std::uint64_t ticks_ = 0;  ///< and its time
  Counter lost_;
  Counter missed_;
  Counter overloads_;
  Counter glitches_;
};

}  // namespace roadbalance::board
