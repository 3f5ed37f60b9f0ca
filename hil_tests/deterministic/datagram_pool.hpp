#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <deque>
#include <span>
#include <string_view>
#include <vector>

#include "common/types/block.hpp"

namespace roadbalance::test {

/// Datagrams under way.  Copies and receivers of one share its bytes; given back, its place is used again.
class DatagramPool {
 public:
  std::uint32_t add(std::string_view channel, std::span<const std::uint8_t> bytes, int uses) {
    if (free_.empty()) {
      free_.push_back(static_cast<std::uint32_t>(all_.size()));
      all_.emplace_back();
    }
    const std::uint32_t number = free_.back();
    free_.pop_back();
    Datagram& datagram = all_[number];
    assert(channel.size() <= datagram.channel.size() && bytes.size() <= datagram.bytes.size());
    std::copy(channel.begin(), channel.end(), datagram.channel.begin());
    datagram.channel_size = channel.size();
    std::copy(bytes.begin(), bytes.end(), datagram.bytes.begin());
    datagram.size = bytes.size();
    datagram.uses = uses;
    return number;
  }

  std::string_view channel(std::uint32_t number) const {
    return {all_[number].channel.data(), all_[number].channel_size};
  }
  std::span<const std::uint8_t> bytes(std::uint32_t number) const {
    return {all_[number].bytes.data(), all_[number].size};
  }
  /// One of its uses is over.
  void release(std::uint32_t number) {
    assert(all_[number].uses > 0);
    if (--all_[number].uses == 0) free_.push_back(number);
  }
  std::size_t largest() const { return all_.size(); }

 private:
  struct Datagram {
    std::array<char, 48> channel;
    std::size_t channel_size = 0;
    std::array<std::uint8_t, kMaxBlockBytes> bytes;
    std::size_t size = 0;
    int uses = 0;
  };
  std::deque<Datagram> all_;
  std::vector<std::uint32_t> free_;
};

}  // namespace roadbalance::test
