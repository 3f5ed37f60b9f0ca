#include "common/bus/codec.hpp"

#include <algorithm>
#include <cassert>
#include <wire/edge_block_t.hpp>
#include <wire/end_t.hpp>
#include <wire/gap_t.hpp>
#include <wire/meta_t.hpp>
#include <wire/scan_block_t.hpp>
#include <wire/signal_block_t.hpp>

#include "common/bus/fields.hpp"
#include "common/bus/scan_format.hpp"

namespace roadbalance {
namespace wire_fields {

/// The beginning of every block.  Node 0 is the host, which has only descriptions to give.
template <typename Field, typename Header, typename Wire>
void list_header(Field& field, Header& h, Wire& m, std::int32_t lowest_node = 1) {
  field(h.node, m.node, within(lowest_node, kLastNode));
  field(h.epoch, m.epoch);
  field(h.sequence, m.sequence, is_index);
  field(h.first_scan, m.first_scan, is_index);
  field(h.scans, m.scans,
        [&m](std::int64_t scans) { return 0 <= scans && scans <= kIndexLimit - m.first_scan; });
  field(h.time_ns, m.time_ns, is_clock);
}

/// The fields of a scan block beside its header and its counts.  scan_format.hpp takes care of the counts.
template <typename Field, typename Scan, typename Wire>
void list_scan(Field& field, Scan& s, const Wire& m) {
  constexpr std::int64_t kLongestPeriod_ps = 1'000'000'000'000;  // one scan a second
  constexpr std::int32_t kQualityLimit = 1 << 16;                // room for bits of later versions
  field.require(1 <= m.scans && m.scans <= kScansPerBlock);
  field(s.period_ps, m.period_ps, within(1, kLongestPeriod_ps));
  field(s.overload, m.overload, below(1 << kChannels));
  field(s.quality, m.quality, below(kQualityLimit));
}

template <>
struct Fields<EdgeBlock> {
  using Wire = wire::edge_block_t;
  static void list(auto& field, auto& b, auto& m) {
    list_header(field, b.header, m);
    field.require(m.scans == 0);
    field(b.edges, m.edges);  // EdgeBlock::is_sound() bounds these
    field(b.size, m.size);
    field(b.codes, m.codes);
  }
};

template <>
struct Fields<SignalBlock> {
  using Wire = wire::signal_block_t;
  static void list(auto& field, auto& b, auto& m) {
    list_header(field, b.header, m);
    field.require(m.scans == 0);
    field(b.samples, m.samples, up_to(kSamplesPerBlock));
    field.counted(b.time_ns, m.sample_ns, m.samples, is_clock);
    field.counted(b.value, m.value, m.samples, is_finite);
    field.counted(b.signal, m.signal, m.samples, below(kMostSignals));
  }
};

template <>
struct Fields<GapBlock> {
  using Wire = wire::gap_t;
  static void list(auto& field, auto& b, auto& m) {
    list_header(field, b.header, m);
    field(b.cause, m.cause, within(GapCause::kRingFull, GapCause::kSlept));
  }
};

template <>
struct Fields<MetaBlock> {
  using Wire = wire::meta_t;
  static constexpr std::int32_t kMostParts = 10'000;
  static void list(auto& field, auto& b, auto& m) {
    list_header(field, b.header, m, 0);
    field.require(m.scans == 0);
    field(b.kind, m.kind, within(MetaKind::kVehicleToml, MetaKind::kRecordJson));
    field(b.part, m.part);
    field(b.parts, m.parts, within(1, kMostParts));
    field.require(below(m.parts)(m.part));
    field.bytes(b.text, m.text, m.size);
  }
};

template <>
struct Fields<EndBlock> {
  using Wire = wire::end_t;
  static void list(auto& field, auto& b, auto& m) {
    list_header(field, b.header, m);
    field.require(m.scans == 0);
    field(b.blocks, m.blocks, is_index);
    field(b.scans_sealed, m.scans_sealed, is_index);
    field(b.scans_missing, m.scans_missing, is_index);
    field(b.blocks_crc32c, m.blocks_crc32c);
  }
};

}  // namespace wire_fields

namespace {

using wire_fields::FieldPass;
using wire_fields::Fields;
using wire_fields::Pass;

static_assert(sizeof(wire::scan_block_t::counts) == 4 * wire_format::kScanCounts);
static_assert(sizeof(wire::edge_block_t::codes) == kEdgeBytesPerBlock);
static_assert(sizeof(wire::meta_t::text) == kMetaBytesPerBlock);

template <typename Block>
void seal_as(BlockKind kind, const Block& block, SealedBlock& out) {
  const auto message = wire_fields::wire_of(block);
  const std::size_t size = wire_format::size_of<typename Fields<Block>::Wire>();
  assert(size <= kMaxBlockBytes);
  out.kind = kind;
  out.header = block.header;
  out.size = static_cast<std::uint32_t>(size);
  message.encode(out.storage.data(), 0, static_cast<int>(size));
  wire_format::write_crc({out.storage.data(), size});
}

template <typename Block>
Block open_as(BlockKind kind, const SealedBlock& block) {
  assert(block.kind == kind);
  (void)kind;
  const auto message = wire_format::decode<typename Fields<Block>::Wire>(block.bytes());
  assert(message);
  return wire_fields::message_of<Block>(*message);
}

bool has_sound_content(const auto&) {
  return true;
}
bool has_sound_content(const wire::edge_block_t& message) {
  return wire_fields::message_of<EdgeBlock>(message).is_sound();
}

template <typename Message>
BlockHeader header_of(const Message& message) {
  BlockHeader header;
  FieldPass<Pass::kDecode> decode;
  wire_fields::list_header(decode, header, message);
  return header;
}

void take(BlockKind kind, const BlockHeader& header, std::span<const std::uint8_t> bytes, SealedBlock& out) {
  out.kind = kind;
  out.header = header;
  out.size = static_cast<std::uint32_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), out.storage.begin());
}

template <typename Block>
Refusal accept_as(BlockKind kind, std::span<const std::uint8_t> bytes, SealedBlock& out, bool crc_is_good) {
  using Message = typename Fields<Block>::Wire;
  if (bytes.size() != wire_format::size_of<Message>()) return Refusal::kWrongSize;
  if (!crc_is_good && !ends_with_its_crc(bytes)) return Refusal::kWrongCrc;
  const auto message = wire_format::decode<Message>(bytes);
  if (!message) return Refusal::kUnknownType;
  if (!wire_fields::in_bounds<Block>(*message) || !has_sound_content(*message)) return Refusal::kOutOfBounds;
  take(kind, header_of(*message), bytes, out);
  return Refusal::kNone;
}

Refusal accept_scan(std::span<const std::uint8_t> bytes, SealedBlock& out, bool crc_is_good) {
  if (bytes.size() != wire_format::kScanBytes) return Refusal::kWrongSize;
  if (!crc_is_good && !ends_with_its_crc(bytes)) return Refusal::kWrongCrc;
  const auto fields = wire_format::read_scan_fields(bytes);
  BlockHeader header = header_of(fields);
  ScanSummary none{};
  FieldPass<Pass::kCheck> check;
  wire_fields::list_header(check, header, fields);
  wire_fields::list_scan(check, none, fields);
  if (!check.is_good()) return Refusal::kOutOfBounds;
  take(BlockKind::kScan, header, bytes, out);
  return Refusal::kNone;
}

}  // namespace

void seal(const ScanBlock& block, SealedBlock& out) {
  const std::span<std::uint8_t> bytes(out.storage.data(), wire_format::kScanBytes);
  out.kind = BlockKind::kScan;
  out.header = block.header;
  out.size = wire_format::kScanBytes;
  wire_format::write_scan(block, wire::scan_block_t::getHash(), bytes);
  wire_format::write_crc(bytes);
}

void seal(const EdgeBlock& block, SealedBlock& out) {
  seal_as(BlockKind::kEdge, block, out);
}
void seal(const SignalBlock& block, SealedBlock& out) {
  seal_as(BlockKind::kSignal, block, out);
}
void seal(const GapBlock& block, SealedBlock& out) {
  seal_as(BlockKind::kGap, block, out);
}
void seal(const MetaBlock& block, SealedBlock& out) {
  assert(block.text.size() <= kMetaBytesPerBlock);
  seal_as(BlockKind::kMeta, block, out);
}
void seal(const EndBlock& block, SealedBlock& out) {
  seal_as(BlockKind::kEnd, block, out);
}

Refusal accept(std::span<const std::uint8_t> bytes, SealedBlock& out, bool crc_is_good) {
  if (bytes.size() < 8) return Refusal::kWrongSize;
  const std::int64_t fingerprint = wire_format::load_i64(bytes.data());
  if (fingerprint == wire::scan_block_t::getHash()) return accept_scan(bytes, out, crc_is_good);
  if (fingerprint == wire::edge_block_t::getHash())
    return accept_as<EdgeBlock>(BlockKind::kEdge, bytes, out, crc_is_good);
  if (fingerprint == wire::gap_t::getHash())
    return accept_as<GapBlock>(BlockKind::kGap, bytes, out, crc_is_good);
  if (fingerprint == wire::meta_t::getHash())
    return accept_as<MetaBlock>(BlockKind::kMeta, bytes, out, crc_is_good);
  if (fingerprint == wire::end_t::getHash())
    return accept_as<EndBlock>(BlockKind::kEnd, bytes, out, crc_is_good);
  if (fingerprint == wire::signal_block_t::getHash())
    return accept_as<SignalBlock>(BlockKind::kSignal, bytes, out, crc_is_good);
  return Refusal::kUnknownType;
}

ScanBlock decode_scan(const SealedBlock& block) {
  assert(block.kind == BlockKind::kScan);
  ScanBlock result;
  result.header = block.header;
  FieldPass<Pass::kDecode> decode;
  wire_fields::list_scan(decode, result, wire_format::read_scan_fields(block.bytes()));
  wire_format::read_scan_counts(block.bytes(), result);
  return result;
}

EdgeBlock decode_edge(const SealedBlock& block) {
  return open_as<EdgeBlock>(BlockKind::kEdge, block);
}
SignalBlock decode_signal(const SealedBlock& block) {
  return open_as<SignalBlock>(BlockKind::kSignal, block);
}
GapBlock decode_gap(const SealedBlock& block) {
  return open_as<GapBlock>(BlockKind::kGap, block);
}
MetaBlock decode_meta(const SealedBlock& block) {
  return open_as<MetaBlock>(BlockKind::kMeta, block);
}
EndBlock decode_end(const SealedBlock& block) {
  return open_as<EndBlock>(BlockKind::kEnd, block);
}

ScanSummary summary_of(const SealedBlock& block) {
  assert(block.kind == BlockKind::kScan);
  ScanSummary result{};
  FieldPass<Pass::kDecode> decode;
  wire_fields::list_scan(decode, result, wire_format::read_scan_fields(block.bytes()));
  return result;
}

std::span<const std::uint8_t> encoded_counts(const SealedBlock& block) {
  assert(block.kind == BlockKind::kScan);
  const auto rows = static_cast<std::size_t>(block.header.scans);
  return block.bytes().subspan(wire_format::kScanCountsAt, rows * kChannels * sizeof(std::int32_t));
}

}  // namespace roadbalance
