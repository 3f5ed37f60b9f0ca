#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace roadbalance::test {

using Datagram = std::vector<std::uint8_t>;

/// Makes datagrams that no program of ours would send, out of nothing and out of real ones that it was shown.
/// Pure: the same seed and the same stock give the same datagrams.
class Malformer {
 public:
  enum Kind {
    kRandomBytes,
    kTruncated,        ///< a real one, cut anywhere
    kLengthened,       ///< a real one with bytes behind it
    kFlippedBits,      ///< a real one, 1 to 8 bits of it
    kReplayed,         ///< a real one, as it was
    kForeignNode,      ///< a good block of a node that does not exist
    kOldEpoch,         ///< a good block of a node that exists, of an epoch that does not
    kForeignAck,       ///< a good acknowledgement of everything, of such an epoch
    kEndlessName,      ///< a channel name without an end
    kAbsurdFragment,   ///< of LCM's long messages: random bounds
    kWrappedFragment,  ///< ends an LCM 1.3.1 receiver: offset + length wraps
    kCutFragment,      ///< ends an LCM 1.3.1 receiver: a header of 19 bytes
    kKinds
  };
  static constexpr std::array<const char*, kKinds> kName = {
      "random bytes", "truncated",   "lengthened",   "flipped bits",    "replayed",         "foreign node",
      "old epoch",    "foreign ack", "endless name", "absurd fragment", "wrapped fragment", "cut fragment"};

  explicit Malformer(std::uint32_t seed) : random_(seed) {}

  /// Keeps a real datagram to work on: up to kStock, then in place of an older one.
  void show(std::span<const std::uint8_t> real);
  bool has_stock() const { return !stock_.empty(); }

  /// The kinds that need a real datagram give random bytes until one was shown.
  Datagram make(Kind kind);
  Kind any_kind() { return static_cast<Kind>(below(kKinds)); }

 private:
  static constexpr std::size_t kStock = 2000;
  std::size_t below(std::size_t end) {
    return std::uniform_int_distribution<std::size_t>(0, end - 1)(random_);
  }
  std::uint8_t byte() { return static_cast<std::uint8_t>(below(256)); }
  Datagram random_bytes(std::size_t size);
  Datagram forged_block(bool foreign_node);
  Datagram forged_ack();
  Datagram fragment(std::uint32_t size, std::uint32_t offset, std::uint16_t number,
                    std::uint16_t count) const;

  std::mt19937 random_;
  std::vector<Datagram> stock_;
};

}  // namespace roadbalance::test
