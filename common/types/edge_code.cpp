#include "common/types/edge_code.hpp"

#include <algorithm>

namespace roadbalance {
namespace {

// A code: bit 0 line; bit 1 not a tooth passing forward, and then bits 2 and 3 kind; above these what the
// stamp is off: 0, -1, 1, -2 ... are 0, 1, 2, 3 ...
constexpr int kToothShift = 2, kOtherShift = 4;
constexpr std::uint64_t kOther = 2;
constexpr std::int64_t kOffLimit_ns = std::int64_t{1} << 30;
// It is stored seven bits a byte, the lowest first; the highest bit of a byte means that more follow.
constexpr int kBitsOfByte = 7;
constexpr std::uint8_t kMore = 0x80;

}  // namespace

std::size_t write_edge(const Edge& edge, std::span<std::uint8_t> codes, std::size_t size,
                       ExpectedEdges& expected) noexcept {
  const std::int64_t off_ns = to_ns(edge.time) - expected.time_ns(edge.line, edge.kind);
  if (off_ns < -kOffLimit_ns || off_ns >= kOffLimit_ns) return 0;
  const auto folded = static_cast<std::uint64_t>(off_ns < 0 ? -2 * off_ns - 1 : 2 * off_ns);
  const auto kind = static_cast<std::uint64_t>(edge.kind);
  std::uint64_t code = edge.kind == EdgeKind::kTooth
                           ? folded << kToothShift | edge.line
                           : folded << kOtherShift | kind << kToothShift | kOther | edge.line;
  std::array<std::uint8_t, kMostEdgeCodeBytes> bytes;
  std::size_t count = 0;
  do {
    bytes[count++] = static_cast<std::uint8_t>((code & (kMore - 1)) | (code >= kMore ? kMore : 0));
    code >>= kBitsOfByte;
  } while (code > 0);
  if (count > codes.size() - size) return 0;
  std::copy_n(bytes.begin(), count, codes.begin() + static_cast<std::ptrdiff_t>(size));
  expected.take(edge.line, edge.kind, to_ns(edge.time));
  return count;
}

std::optional<Edge> EdgeReader::next() noexcept {
  std::uint64_t code = 0;
  std::size_t count = 0;
  for (bool more = true; more; ++count) {
    if (count == std::min(codes_.size(), kMostEdgeCodeBytes)) return std::nullopt;
    const std::uint8_t byte = codes_[count];
    if (count > 0 && byte == 0) return std::nullopt;
    code |= static_cast<std::uint64_t>(byte & (kMore - 1)) << (kBitsOfByte * count);
    more = (byte & kMore) != 0;
  }
  const auto line = static_cast<std::uint8_t>(code & 1);
  const bool other = (code & kOther) != 0;
  const auto kind = other ? static_cast<EdgeKind>(code >> kToothShift & 3) : EdgeKind::kTooth;
  if (other && kind == EdgeKind::kTooth) return std::nullopt;  // there is a shorter form
  const std::uint64_t folded = code >> (other ? kOtherShift : kToothShift);
  const auto half = static_cast<std::int64_t>(folded >> 1);
  const std::int64_t time_ns = expected_.time_ns(line, kind) + ((folded & 1) != 0 ? -half - 1 : half);
  if (time_ns < last_ns_) return std::nullopt;
  codes_ = codes_.subspan(count);
  expected_.take(line, kind, time_ns);
  last_ns_ = time_ns;
  return Edge{.time = node_time_from_ns(time_ns), .line = line, .kind = kind};
}

}  // namespace roadbalance
