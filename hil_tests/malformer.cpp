#include "hil_tests/malformer.hpp"

#include <algorithm>
#include <optional>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/control_messages.hpp"

namespace roadbalance::test {
namespace {

constexpr std::size_t kHeader = 8;  // magic and number of a short message
constexpr std::int32_t kNobody = kLastNode - 1;
constexpr std::int64_t kNoEpoch = 0x0123456789ABCDEF;

void append_u32(Datagram& to, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) to.push_back(static_cast<std::uint8_t>(value >> shift));
}

Datagram message(const std::string& channel, std::span<const std::uint8_t> data) {
  const std::string front = std::string("LC02\0\0\0\0", kHeader) + channel + '\0';
  Datagram made(front.size() + data.size());
  std::copy(data.begin(), data.end(), std::copy(front.begin(), front.end(), made.begin()));
  return made;
}

/// The data of a short message, behind header and channel name.
std::span<const std::uint8_t> data_of(const Datagram& datagram) {
  if (datagram.size() < kHeader) return {};
  const auto end = std::find(datagram.begin() + kHeader, datagram.end(), 0);
  return end == datagram.end() ? std::span<const std::uint8_t>() : std::span(end + 1, datagram.end());
}

}  // namespace

void Malformer::show(std::span<const std::uint8_t> real) {
  if (stock_.size() < kStock)
    stock_.emplace_back(real.begin(), real.end());
  else
    stock_[below(kStock)].assign(real.begin(), real.end());
}

Datagram Malformer::random_bytes(std::size_t size) {
  Datagram made(size);
  for (auto& b : made) b = byte();
  return made;
}

Datagram Malformer::forged_block(bool foreign_node) {
  SealedBlock sealed;
  for (int attempt = 0; attempt < 20; ++attempt) {
    if (accept(data_of(stock_[below(stock_.size())]), sealed) != Refusal::kNone ||
        sealed.kind != BlockKind::kScan)
      continue;
    ScanBlock block = decode_scan(sealed);
    if (foreign_node)
      block.header.node = kNobody;
    else
      block.header.epoch = kNoEpoch;
    seal(block, sealed);
    return message(block_channel(block.header.node, BlockKind::kScan), sealed.bytes());
  }
  return random_bytes(100);
}

Datagram Malformer::forged_ack() {
  constexpr std::int64_t kAll = 1'000'000'000;
  const auto node = static_cast<std::int32_t>(1 + below(3));
  return message(ack_channel(node), encode(Ack{.node = node,
                                               .epoch = kNoEpoch,
                                               .incarnation = 1,
                                               .number = kAll,
                                               .received = kAll,
                                               .durable = kAll,
                                               .credit = kAll,
                                               .missing = {}}));
}

Datagram Malformer::fragment(std::uint32_t size, std::uint32_t offset, std::uint16_t number,
                             std::uint16_t count) const {
  Datagram made{'L', 'C', '0', '3', 0, 0, 0, 1};
  append_u32(made, size);
  append_u32(made, offset);
  append_u32(made, static_cast<std::uint32_t>(number) << 16 | count);
  return made;
}

Datagram Malformer::make(Kind kind) {
  if (kind == kWrappedFragment) {
    Datagram made = fragment(100, 0xFFFFFFF0, 0, 2);
    made.insert(made.end(), {'A', 0});
    made.resize(made.size() + 32, 'x');
    return made;
  }
  if (kind == kCutFragment) {
    Datagram made = fragment(100, 60, 0, 2);
    made.pop_back();
    return made;
  }
  if (kind == kAbsurdFragment) {
    Datagram made = fragment(static_cast<std::uint32_t>(random_()), static_cast<std::uint32_t>(random_()),
                             static_cast<std::uint16_t>(below(4)), static_cast<std::uint16_t>(below(4)));
    const Datagram more = random_bytes(below(1000));
    made.insert(made.end(), more.begin(), more.end());
    return made;
  }
  if (kind == kEndlessName) {
    Datagram made{'L', 'C', '0', '2', 0, 0, 0, 1};
    made.resize(kHeader + below(1400), 'R');
    return made;
  }
  if (kind == kForeignAck) return forged_ack();
  if (kind == kRandomBytes || stock_.empty()) return random_bytes(below(1400));
  if (kind == kForeignNode || kind == kOldEpoch) return forged_block(kind == kForeignNode);

  Datagram made = stock_[below(stock_.size())];
  if (kind == kTruncated) made.resize(below(made.size()));
  if (kind == kLengthened) made.resize(made.size() + 1 + below(100), byte());
  if (kind == kFlippedBits)
    for (std::size_t flips = 1 + below(8); flips > 0; --flips)
      made[below(made.size())] ^= static_cast<std::uint8_t>(1 << below(8));
  return made;
}

}  // namespace roadbalance::test
