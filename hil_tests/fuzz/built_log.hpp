#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/log_event.hpp"
#include "hil_tests/fuzz/byte_reader.hpp"
#include "hil_tests/fuzz/true_node.hpp"

namespace roadbalance::fuzz {

using Bytes = std::vector<std::uint8_t>;
inline constexpr TrueNode kLogNode{1, 5, 1 << 20};
inline constexpr std::size_t kMostLogBytes = 20'000;

inline void append_event(const std::string& channel, std::span<const std::uint8_t> data, Bytes& log) {
  const auto header = encode_log_header({.number = 1, .timestamp_us = 2, .channel = channel, .data = data});
  log.insert(log.end(), header.begin(), header.end());
  log.insert(log.end(), channel.begin(), channel.end());
  log.insert(log.end(), data.begin(), data.end());
}

/// Good events of kLogNode and damage between them, as the fuzzer chooses.
inline Bytes build_log(ByteReader& in) {
  Bytes log;
  for (std::int64_t sequence = 1; !in.empty() && log.size() < kMostLogBytes;) {
    const std::uint8_t what = in.byte();
    const SealedBlock block = kLogNode.block(sequence);
    if (what % 4 != 0) {
      append_event(block_channel(kLogNode.node, block.kind), block.bytes(), log);
      ++sequence;
    } else if (what % 8 == 0) {
      const auto garbage = in.take(in.byte());
      log.insert(log.end(), garbage.begin(), garbage.end());
    } else if (!log.empty()) {
      const auto at = static_cast<std::size_t>(in.number(2)) % log.size();
      if (what & 8)
        log.resize(at);
      else
        log[at] ^= static_cast<std::uint8_t>(1 << (what >> 4 & 7));
    }
  }
  return log;
}

/// True for a good block that kLogNode never sealed.
inline bool is_false_block(const Bytes& data) {
  SealedBlock block;
  if (accept(data, block) != Refusal::kNone) return false;
  const SealedBlock sealed = kLogNode.block(block.header.sequence);
  return !std::equal(data.begin(), data.end(), sealed.bytes().begin(), sealed.bytes().end());
}

}  // namespace roadbalance::fuzz
