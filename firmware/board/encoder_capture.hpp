#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/board/counter.hpp"
#include "firmware/board/hardware.hpp"
#include "firmware/board/interrupt_ring.hpp"
#include "firmware/board/packet.hpp"

namespace roadbalance::board {

/// An event at an encoder, with the hardware timer's stamp.
struct CapturedEdge {
  std::uint64_t ticks = 0;
  std::uint8_t line = 0;
  PacketEdgeKind kind = PacketEdgeKind::kToothForward;
  std::uint16_t lost = 0;
};

/// Makes teeth and zero marks of the encoders' level changes, and keeps them for the USB.
///
/// A tooth is one flank of A, and the zero mark one flank of Z, always at the same place of the wheel.  With
/// quadrature, A rises there with B low forward, and falls there with B low backward; the other two changes
/// of A are the tooth's far side.  So a wheel that trembles about a flank counts it forth and back.
class EncoderCapture {
 public:
  static constexpr std::size_t kEdges = 1024;

  /// Begins a run; while no interrupt comes.  Edges are kept only from keep_from_now() on.
  void start(const std::array<EncoderSetup, kLines>& setup, const Hardware& hardware);
  void keep_from_now() { keeping_ = true; }

  /// Interrupt: an input has now this level.  Returns the tooth or zero mark that this is, if any.
  ///
  /// An edge that does not fit, or that comes behind a later edge or conversion, is lost: counted, and
  /// declared by a mark in front of the line's next edge.
  std::optional<CapturedEdge> line_change(std::size_t line, Signal signal, bool high, std::uint64_t ticks);

  /// Interrupt: a conversion was at this time; no edge before it may follow.
  void pass(std::uint64_t ticks) { passed_ticks_ = ticks; }

  /// Main loop's end.
  InterruptRing<CapturedEdge, kEdges>& queue() { return queue_; }
  std::uint32_t lost() const { return lost_.value(); }

 private:
  struct Line {
    std::uint16_t flags = 0;
    bool used = false;
    bool b = false;
    bool forward = true;
    std::uint32_t lost = 0;  ///< not yet declared
  };
  std::optional<PacketEdgeKind> decode(Line& line, Signal signal, bool high) const;
  bool keep(const CapturedEdge& edge);

  std::array<Line, kLines> lines_{};
  InterruptRing<CapturedEdge, kEdges> queue_;
  bool keeping_ = false;
  std::uint64_t passed_ticks_ = 0;
  std::uint64_t newest_ticks_ = 0;
  Counter lost_;
};

}  // namespace roadbalance::board
