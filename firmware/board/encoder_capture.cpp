#include "firmware/board/encoder_capture.hpp"

#include <algorithm>

namespace roadbalance::board {
namespace {

bool is_active(std::uint16_t flags, EncoderFlag inverted, bool high) {
  return high != ((flags & inverted) != 0);
}

}  // namespace

void EncoderCapture::start(const std::array<EncoderSetup, kLines>& setup, const Hardware& hardware) {
  queue_.clear();
  lost_.clear();
  keeping_ = false;
  passed_ticks_ = 0;
  newest_ticks_ = 0;
  for (std::size_t k = 0; k < kLines; ++k) {
    lines_[k] = {};
    lines_[k].flags = setup[k].flags;
    lines_[k].used = setup[k].pulses_per_turn != 0;
    lines_[k].b = is_active(setup[k].flags, kInvertB, hardware.level(k, Signal::kB));
  }
}

std::optional<CapturedEdge> EncoderCapture::line_change(std::size_t line, Signal signal, bool high,
                                                        std::uint64_t ticks) {
  if (line >= kLines || !lines_[line].used) return std::nullopt;
  const std::optional<PacketEdgeKind> kind = decode(lines_[line], signal, high);
  if (!kind) return std::nullopt;
  const CapturedEdge edge{ticks, static_cast<std::uint8_t>(line), *kind, 0};
  if (keeping_ && !keep(edge)) {
    ++lines_[line].lost;
    lost_.add();
  }
  return edge;
}

std::optional<PacketEdgeKind> EncoderCapture::decode(Line& line, Signal signal, bool high) const {
  const bool quadrature = (line.flags & kQuadrature) != 0;
  switch (signal) {
    case Signal::kA: {
      const bool rises = is_active(line.flags, kInvertA, high);
      if (quadrature ? line.b : !rises) return std::nullopt;
      line.forward = rises;
      return rises ? PacketEdgeKind::kToothForward : PacketEdgeKind::kToothBackward;
    }
    case Signal::kB:
      line.b = is_active(line.flags, kInvertB, high);
      return std::nullopt;
    case Signal::kZero:
      // Backward the mark's place is passed as it ends.
      if ((line.flags & kZeroWired) == 0) return std::nullopt;
      if (is_active(line.flags, kInvertZero, high) != line.forward) return std::nullopt;
      return PacketEdgeKind::kZeroMark;
  }
  return std::nullopt;
}

bool EncoderCapture::keep(const CapturedEdge& edge) {
  Line& line = lines_[edge.line];
  const std::size_t needed = line.lost > 0 ? 2 : 1;
  if (edge.ticks < newest_ticks_ || (passed_ticks_ != 0 && edge.ticks <= passed_ticks_)) return false;
  if (queue_.free() < needed) return false;
  newest_ticks_ = edge.ticks;
  if (line.lost > 0) {
    const auto reported = static_cast<std::uint16_t>(std::min<std::uint32_t>(line.lost, UINT16_MAX));
    *queue_.room() = {edge.ticks, edge.line, PacketEdgeKind::kLost, reported};
    queue_.publish();
    line.lost = 0;
  }
  *queue_.room() = edge;
  queue_.publish();
  return true;
}

}  // namespace roadbalance::board
