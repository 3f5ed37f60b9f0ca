#pragma once

#include <cstdint>
#include <span>

#include "firmware/board/encoder_capture.hpp"
#include "firmware/board/packet.hpp"
#include "firmware/board/sample_ring.hpp"

namespace roadbalance::board {

/// Decides when a packet goes out and what is in it.  Main loop only.
class Packetizer {
 public:
  struct Setup {
    std::uint32_t token = 0;
    std::uint32_t tick_hz = 1;
    std::uint32_t ticks_per_scan = 1;
    std::uint32_t limit_us = 1;
    bool pattern = false;
  };
  void start(const Setup& setup, std::uint64_t now_ticks);

  /// The next packet, if one is due.  Returns its size, or 0.
  /// @param packet  room for kMaxPacketBytes
  /// @param locked  ReferenceGenerator::locked()
  std::size_t next(std::uint64_t now_ticks, SampleRing& samples, EncoderCapture& encoders,
                   std::uint32_t locked, std::span<std::uint8_t> packet);

  std::uint32_t packets() const { return sequence_; }
  std::uint64_t next_scan() const { return next_scan_; }

 private:
  struct Content {
    std::size_t scans = 0;
    std::size_t edges = 0;
  };
  bool is_due(std::uint64_t now_ticks, SampleRing& samples, EncoderCapture& encoders) const;
  Content fitting(SampleRing& samples, EncoderCapture& encoders) const;
  bool continues(const StoredScan& first, const StoredScan& scan, std::size_t k) const;
  PacketHeader header(std::uint64_t now_ticks, SampleRing& samples, EncoderCapture& encoders,
                      const Content& content) const;

  Setup setup_;
  std::uint32_t limit_ticks_ = 0;
  std::uint32_t silence_ticks_ = 0;
  std::uint32_t tolerance_ticks_ = 0;  ///< of a scan's time within a packet
  std::uint32_t sequence_ = 0;
  std::uint64_t next_scan_ = 0;
  std::uint64_t sent_ticks_ = 0;
};

}  // namespace roadbalance::board
