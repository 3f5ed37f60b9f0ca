#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "common/types/scan.hpp"

namespace roadbalance {

/// Edges in an edge_block_t are coded by the difference of a stamp from the one expected by the teeth before
/// it.
///
/// A tooth is expected one period after the line's tooth before; a mark or a loss at that tooth.  The period
/// is the first interval of the line in this block, then grows by an eighth (rounded down) of what each
/// further interval is longer.  For both lines the block's time_ns stands for the tooth before the first, and
/// the period is 0.
class ExpectedEdges {
 public:
  explicit ExpectedEdges(std::int64_t begin_ns = 0) { line_.fill({begin_ns, 0, 0}); }

  std::int64_t time_ns(std::uint8_t line, EdgeKind kind) const noexcept {
    return line_[line].tooth_ns + (is_tooth(kind) ? line_[line].period_ns : 0);
  }
  void take(std::uint8_t line, EdgeKind kind, std::int64_t time_ns) noexcept {
    if (!is_tooth(kind)) return;
    Line& l = line_[line];
    const std::int64_t interval_ns = time_ns - l.tooth_ns;
    if (l.teeth == 1) l.period_ns = interval_ns;
    if (l.teeth > 1) l.period_ns += (interval_ns - l.period_ns) >> 3;
    if (l.teeth < 2) ++l.teeth;
    l.tooth_ns = time_ns;
  }

 private:
  struct Line {
    std::int64_t tooth_ns, period_ns;
    int teeth;  ///< so far; 2 for more
  };
  static bool is_tooth(EdgeKind kind) noexcept {
    return kind == EdgeKind::kTooth || kind == EdgeKind::kToothBackward;
  }
  std::array<Line, kEncoderLines> line_;
};

/// Bytes of the longest code.
inline constexpr std::size_t kMostEdgeCodeBytes = 5;

/// Appends an edge at codes[size] and moves `expected` on; returns the bytes it takes, 0 if they do not fit
/// or its stamp is 2^30 ns or more from where it is expected.
std::size_t write_edge(const Edge& edge, std::span<std::uint8_t> codes, std::size_t size,
                       ExpectedEdges& expected) noexcept;

/// Reads the edges of a block, one after the other.
class EdgeReader {
 public:
  EdgeReader(std::int64_t begin_ns, std::span<const std::uint8_t> codes)
      : codes_(codes), expected_(begin_ns), last_ns_(begin_ns) {}

  /// Nothing at the end, and where the next code is none: too long, not in the shortest form, or of an edge
  /// before the last.
  std::optional<Edge> next() noexcept;
  bool at_end() const noexcept { return codes_.empty(); }

 private:
  std::span<const std::uint8_t> codes_;
  ExpectedEdges expected_;
  std::int64_t last_ns_;
};

}  // namespace roadbalance
