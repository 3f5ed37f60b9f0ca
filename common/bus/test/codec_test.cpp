#include "common/bus/codec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>
#include <wire/scan_block_t.hpp>

#include "common/bus/types.hpp"
#include "common/types/crc32c.hpp"

namespace roadbalance {
namespace {

constexpr BlockHeader kHeader{.node = 3,
                              .epoch = 0x123456789ABCDEF0,
                              .sequence = (std::int64_t{1} << 32) + 5,
                              .first_scan = (std::int64_t{1} << 31) - 1,
                              .scans = 0,
                              .time_ns = 987'654'321'012};

ScanBlock some_scans() {
  std::mt19937 random(2);
  ScanBlock block;
  block.header = kHeader;
  block.header.scans = 17;
  block.period_ps = 500'000'000;
  for (auto& row : block.counts)
    for (auto& count : row) count = static_cast<std::int32_t>(random());
  block.overload = 0x8001;
  block.quality = kQualityOverload | kQualityAfterGap;
  return block;
}

EdgeBlock some_edges() {
  EdgeBlock block;
  block.header = kHeader;
  for (int k = 0; k < 200; ++k)
    block.add({.time = node_time_from_ns(1000 * k * k), .line = static_cast<std::uint8_t>(k & 1)});
  return block;
}

SignalBlock some_signals() {
  SignalBlock block;
  block.header = kHeader;
  for (int k = 0; k < 50; ++k)
    block.add({.time = node_time_from_ns(987'654'321'012 + 1000 * k),
               .signal = static_cast<std::uint16_t>(5 * k),
               .value = 0.1 * k - 1.0});
  return block;
}

MetaBlock some_text() {
  return {.header = kHeader,
          .kind = MetaKind::kVehicleToml,
          .part = 2,
          .parts = 4,
          .text = "[model]\nkind = 7\n"};
}

std::vector<SealedBlock> one_of_each() {
  std::vector<SealedBlock> blocks(kBlockKinds);
  seal(some_scans(), blocks[0]);
  seal(some_edges(), blocks[1]);
  GapBlock gap{.header = kHeader, .cause = GapCause::kDeviceOverrun};
  gap.header.scans = 12345;
  seal(gap, blocks[2]);
  seal(some_text(), blocks[3]);
  seal(EndBlock{.header = kHeader,
                .blocks = 9,
                .scans_sealed = 8,
                .scans_missing = 7,
                .blocks_crc32c = 0xFEDCBA98u},
       blocks[4]);
  seal(some_signals(), blocks[5]);
  return blocks;
}

// As an attacker or an older program would: any content, with a CRC that is right.
std::vector<std::uint8_t> with_crc(std::vector<std::uint8_t> bytes) {
  const std::uint32_t crc = crc32c({bytes.data(), bytes.size() - 4});
  for (std::size_t k = 0; k < 4; ++k)
    bytes[bytes.size() - 4 + k] = static_cast<std::uint8_t>(crc >> (24 - 8 * k));
  return bytes;
}

TEST(Codec, GivesBackWhatWasSealed) {
  const auto blocks = one_of_each();
  std::vector<SealedBlock> accepted(blocks.size());
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    ASSERT_EQ(accept(blocks[k].bytes(), accepted[k]), Refusal::kNone);
    EXPECT_EQ(accepted[k].kind, blocks[k].kind);
    EXPECT_EQ(accepted[k].header, blocks[k].header);
    EXPECT_TRUE(std::ranges::equal(accepted[k].bytes(), blocks[k].bytes()));
  }
  const ScanBlock scans = decode_scan(accepted[0]);
  EXPECT_EQ(scans.header, some_scans().header);
  EXPECT_EQ(scans.counts, some_scans().counts);
  EXPECT_EQ(scans.period_ps, some_scans().period_ps);
  EXPECT_EQ(scans.overload, some_scans().overload);
  EXPECT_EQ(scans.quality, some_scans().quality);
  EXPECT_EQ(decode_edge(accepted[1]).codes, some_edges().codes);
  EXPECT_EQ(decode_edge(accepted[1]).edges, 200);
  EXPECT_EQ(decode_gap(accepted[2]).cause, GapCause::kDeviceOverrun);
  EXPECT_EQ(decode_gap(accepted[2]).header.scans, 12345);
  EXPECT_EQ(decode_meta(accepted[3]).text, some_text().text);
  EXPECT_EQ(decode_meta(accepted[3]).part, 2);
  EXPECT_EQ(decode_meta(accepted[3]).parts, 4);
  EXPECT_EQ(decode_end(accepted[4]).blocks, 9);
  EXPECT_EQ(decode_end(accepted[4]).scans_sealed, 8);
  EXPECT_EQ(decode_end(accepted[4]).scans_missing, 7);
  EXPECT_EQ(decode_end(accepted[4]).blocks_crc32c, 0xFEDCBA98u);
  const SignalBlock signals = decode_signal(accepted[5]);
  EXPECT_EQ(signals.header, some_signals().header);
  EXPECT_EQ(signals.samples, 50);
  EXPECT_EQ(signals.time_ns, some_signals().time_ns);
  EXPECT_EQ(signals.value, some_signals().value);
  EXPECT_EQ(signals.signal, some_signals().signal);
}

// Scan blocks are written by hand; LCM's generated code must find in them what was meant.
TEST(Codec, WritesScansAsLcmDoes) {
  const ScanBlock scans = some_scans();
  SealedBlock sealed;
  seal(scans, sealed);
  wire::scan_block_t message;
  ASSERT_EQ(message.getEncodedSize(), static_cast<int>(sealed.size));
  ASSERT_EQ(message.decode(sealed.storage.data(), 0, static_cast<int>(sealed.size)),
            static_cast<int>(sealed.size));
  EXPECT_EQ(message.node, scans.header.node);
  EXPECT_EQ(message.epoch, scans.header.epoch);
  EXPECT_EQ(message.sequence, scans.header.sequence);
  EXPECT_EQ(message.first_scan, scans.header.first_scan);
  EXPECT_EQ(message.scans, scans.header.scans);
  EXPECT_EQ(message.time_ns, scans.header.time_ns);
  EXPECT_EQ(message.period_ps, scans.period_ps);
  for (std::size_t row = 0; row < scans.counts.size(); ++row)
    EXPECT_TRUE(std::ranges::equal(message.counts[row], scans.counts[row])) << row;
  EXPECT_EQ(message.overload, scans.overload);
  EXPECT_EQ(message.quality, scans.quality);
  std::vector<std::uint8_t> again(sealed.size);
  message.encode(again.data(), 0, static_cast<int>(again.size()));
  EXPECT_TRUE(std::ranges::equal(again, sealed.bytes()));
}

TEST(Codec, EveryBlockIsDescribedAndFitsIntoOneDatagram) {
  EXPECT_EQ(block_types().size(), kBlockKinds);
  for (const auto& type : block_types()) EXPECT_LE(type.bytes, kMaxBlockBytes) << type.name;
}

TEST(Codec, RefusesEverySingleBitFlip) {
  SealedBlock out;
  for (const auto& block : one_of_each()) {
    std::vector<std::uint8_t> bytes(block.bytes().begin(), block.bytes().end());
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << (bit % 8));
      ASSERT_NE(accept(bytes, out), Refusal::kNone) << "bit " << bit;
      bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << (bit % 8));
    }
  }
}

TEST(Codec, RefusesEveryOtherSize) {
  SealedBlock out;
  for (const auto& block : one_of_each()) {
    std::vector<std::uint8_t> bytes(block.bytes().begin(), block.bytes().end());
    bytes.push_back(0);
    EXPECT_EQ(accept(bytes, out), Refusal::kWrongSize);
    bytes.pop_back();
    while (!bytes.empty()) {
      bytes.pop_back();
      ASSERT_EQ(accept(bytes, out), Refusal::kWrongSize) << bytes.size();
    }
  }
}

TEST(Codec, RefusesATypeItDoesNotKnow) {
  const auto blocks = one_of_each();
  std::vector<std::uint8_t> bytes(blocks[0].bytes().begin(), blocks[0].bytes().end());
  bytes[0] ^= 1;
  SealedBlock out;
  EXPECT_EQ(accept(with_crc(bytes), out), Refusal::kUnknownType);
}

TEST(Codec, RefusesFieldsOutOfBoundsThoughTheCrcIsRight) {
  SealedBlock sealed, out;
  const auto refused = [&](const auto& block) {
    seal(block, sealed);
    return accept(sealed.bytes(), out) == Refusal::kOutOfBounds;
  };
  ScanBlock scans = some_scans();
  scans.header.scans = 21;
  EXPECT_TRUE(refused(scans));
  scans.header.scans = 0;
  EXPECT_TRUE(refused(scans));
  scans = some_scans();
  scans.header.node = 0;
  EXPECT_TRUE(refused(scans));
  scans = some_scans();
  scans.header.sequence = -1;
  EXPECT_TRUE(refused(scans));
  scans = some_scans();
  scans.header.first_scan = std::numeric_limits<std::int64_t>::max();
  EXPECT_TRUE(refused(scans));
  scans = some_scans();
  scans.header.sequence = kIndexLimit + 1;
  EXPECT_TRUE(refused(scans));
  scans = some_scans();
  scans.header.time_ns = -kClockLimit_ns - 1;
  EXPECT_TRUE(refused(scans));
  GapBlock beyond{.header = some_scans().header};
  beyond.header.first_scan = kIndexLimit;
  beyond.header.scans = 1;
  EXPECT_TRUE(refused(beyond));
  scans = some_scans();
  scans.period_ps = 0;
  EXPECT_TRUE(refused(scans));
  EdgeBlock edges = some_edges();
  ++edges.edges;
  EXPECT_TRUE(refused(edges));
  edges = some_edges();
  edges.size = kEdgeBytesPerBlock + 1;
  EXPECT_TRUE(refused(edges));
  edges.size = -1;
  EXPECT_TRUE(refused(edges));
  edges = some_edges();
  edges.codes[static_cast<std::size_t>(edges.size - 1)] |= 0x80;
  EXPECT_TRUE(refused(edges)) << "a code that does not end";
  GapBlock absence{.header = kHeader, .cause = GapCause::kSlept};
  EXPECT_FALSE(refused(absence));
  absence.cause = static_cast<GapCause>(static_cast<int>(GapCause::kSlept) + 1);
  EXPECT_TRUE(refused(absence));
  MetaBlock text = some_text();
  text.part = 4;
  EXPECT_TRUE(refused(text));
}

TEST(Codec, RefusesSignalsOutOfBoundsThoughTheCrcIsRight) {
  SealedBlock sealed, out;
  const auto with = [&](auto&& change) {
    SignalBlock block = some_signals();
    change(block);
    seal(block, sealed);
    return accept(sealed.bytes(), out);
  };
  EXPECT_EQ(with([](SignalBlock&) {}), Refusal::kNone);
  EXPECT_EQ(with([](SignalBlock& b) { b.samples = 0; }), Refusal::kNone);
  EXPECT_EQ(with([](SignalBlock& b) { b.samples = kSamplesPerBlock; }), Refusal::kNone);
  EXPECT_EQ(with([](SignalBlock& b) { b.samples = kSamplesPerBlock + 1; }), Refusal::kOutOfBounds);
  EXPECT_EQ(with([](SignalBlock& b) { b.samples = -1; }), Refusal::kOutOfBounds);
  EXPECT_EQ(with([](SignalBlock& b) { b.header.scans = 1; }), Refusal::kOutOfBounds);
  EXPECT_EQ(with([](SignalBlock& b) { b.signal[3] = kMostSignals - 1; }), Refusal::kNone);
  EXPECT_EQ(with([](SignalBlock& b) { b.signal[3] = kMostSignals; }), Refusal::kOutOfBounds);
  EXPECT_EQ(with([](SignalBlock& b) { b.signal[49] = -1; }), Refusal::kOutOfBounds);
  EXPECT_EQ(with([](SignalBlock& b) { b.time_ns[3] = kClockLimit_ns; }), Refusal::kNone);
  EXPECT_EQ(with([](SignalBlock& b) { b.time_ns[3] = kClockLimit_ns + 1; }), Refusal::kOutOfBounds);
  EXPECT_EQ(with([](SignalBlock& b) { b.time_ns[0] = -kClockLimit_ns - 1; }), Refusal::kOutOfBounds);
  for (const double none : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity()})
    EXPECT_EQ(with([none](SignalBlock& b) { b.value[49] = none; }), Refusal::kOutOfBounds) << none;
}

TEST(Codec, RefusesATextLongerThanItsField) {
  SealedBlock sealed, out;
  seal(some_text(), sealed);
  std::vector<std::uint8_t> bytes(sealed.bytes().begin(), sealed.bytes().end());
  const std::size_t size_at = bytes.size() - 4 - kMetaBytesPerBlock - 4;
  bytes[size_at + 2] = 0x7F;  // far beyond 1200, and the field before it still good
  EXPECT_EQ(accept(with_crc(bytes), out), Refusal::kOutOfBounds);
}

}  // namespace
}  // namespace roadbalance
