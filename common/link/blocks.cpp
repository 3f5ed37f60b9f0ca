#include "common/link/blocks.hpp"

#include <algorithm>

namespace roadbalance {
namespace {
// A word of edge_block_t: bit 0 line, bit 1 kind, bits 2..30 nanoseconds since the edge before.
constexpr int kTimeShift = 2;
constexpr std::int64_t kTimeLimit_ns = std::int64_t{1} << 29;
}  // namespace

bool EdgeBlock::add(const Edge& edge) {
  const std::int64_t time_ns = to_ns(edge.time);
  if (edges == 0) {
    header.time_ns = time_ns;
    last_ns_ = time_ns;
  }
  const std::int64_t since_ns = time_ns - last_ns_;
  if (edges == kEdgesPerBlock || since_ns < 0 || since_ns >= kTimeLimit_ns) return false;
  const std::int64_t word =
      (since_ns << kTimeShift) | (static_cast<std::int64_t>(edge.kind) << 1) | edge.line;
  words[static_cast<std::size_t>(edges)] = static_cast<std::int32_t>(word);
  ++edges;
  last_ns_ = time_ns;
  return true;
}

std::vector<Edge> EdgeBlock::unpack() const {
  std::vector<Edge> result;
  result.reserve(static_cast<std::size_t>(edges));
  std::int64_t time_ns = header.time_ns;
  for (std::size_t k = 0; k < static_cast<std::size_t>(edges); ++k) {
    const std::int32_t word = words[k];
    time_ns += word >> kTimeShift;
    result.push_back({.time = node_time_from_ns(time_ns),
                      .line = static_cast<std::uint8_t>(word & 1),
                      .kind = (word & 2) ? EdgeKind::kZeroMark : EdgeKind::kTooth});
  }
  return result;
}

std::vector<MetaBlock> split_text(MetaKind kind, const std::string& text) {
  constexpr std::size_t kSize = kMetaBytesPerBlock;
  std::vector<MetaBlock> parts(std::max<std::size_t>(1, (text.size() + kSize - 1) / kSize));
  for (std::size_t k = 0; k < parts.size(); ++k) {
    parts[k].kind = kind;
    parts[k].part = static_cast<std::int32_t>(k);
    parts[k].parts = static_cast<std::int32_t>(parts.size());
    parts[k].text = text.substr(k * kSize, kSize);
  }
  return parts;
}

}  // namespace roadbalance
