#include "common/link/blocks.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace roadbalance {
namespace {
// A word of edge_block_t: bit 0 line, bits 1 and 2 kind, bits 3..30 nanoseconds since the edge before.
constexpr int kTimeShift = 3;
constexpr std::int64_t kTimeLimit_ns = std::int64_t{1} << 28;
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
                      .kind = static_cast<EdgeKind>(word >> 1 & 3)});
  }
  return result;
}

bool SignalBlock::add(const SignalSample& sample) {
  assert(std::isfinite(sample.value) && sample.signal < kMostSignals);
  if (samples == 0) header.time_ns = to_ns(sample.time);
  if (samples == kSamplesPerBlock) return false;
  const auto k = static_cast<std::size_t>(samples++);
  time_ns[k] = to_ns(sample.time);
  value[k] = sample.value;
  signal[k] = static_cast<std::int16_t>(sample.signal);
  return true;
}

std::vector<SignalSample> SignalBlock::unpack() const {
  std::vector<SignalSample> result;
  result.reserve(static_cast<std::size_t>(samples));
  for (std::size_t k = 0; k < static_cast<std::size_t>(samples); ++k)
    result.push_back({node_time_from_ns(time_ns[k]), static_cast<std::uint16_t>(signal[k]), value[k]});
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
