#include "common/types/blocks.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "common/types/crc32c.hpp"

namespace roadbalance {
bool EdgeBlock::add(const Edge& edge) {
  const std::int64_t time_ns = to_ns(edge.time);
  if (edges == 0) {
    header.time_ns = last_ns_ = time_ns;
    expected_ = ExpectedEdges(time_ns);
  }
  if (time_ns < last_ns_) return false;
  const std::size_t bytes = write_edge(edge, codes, static_cast<std::size_t>(size), expected_);
  if (bytes == 0) return false;
  size += static_cast<std::int32_t>(bytes);
  ++edges;
  last_ns_ = time_ns;
  return true;
}

bool EdgeBlock::is_sound() const {
  if (size < 0 || size > kEdgeBytesPerBlock) return false;
  EdgeReader codes_left = reader();
  std::int32_t count = 0;
  while (codes_left.next()) ++count;
  return codes_left.at_end() && count == edges;
}

std::vector<Edge> EdgeBlock::unpack() const {
  std::vector<Edge> result;
  result.reserve(static_cast<std::size_t>(edges));
  EdgeReader codes_left = reader();
  while (const auto edge = codes_left.next()) result.push_back(*edge);
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

void BlockSum::add(const SealedBlock& block) {
  crc32c_ = roadbalance::crc32c(block.bytes().last(4), crc32c_);
}

void BlockSum::add(std::uint32_t block_crc32c) {
  std::array<std::uint8_t, 4> bytes{};
  for (std::size_t k = 0; k < bytes.size(); ++k)
    bytes[k] = static_cast<std::uint8_t>(block_crc32c >> (24 - 8 * k));
  crc32c_ = roadbalance::crc32c(bytes, crc32c_);
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
