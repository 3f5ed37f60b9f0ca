#include "common/bus/codec.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <wire/edge_block_t.hpp>
#include <wire/end_t.hpp>
#include <wire/gap_t.hpp>
#include <wire/meta_t.hpp>
#include <wire/scan_block_t.hpp>
#include <wire/signal_block_t.hpp>

#include "common/bus/scan_format.hpp"
#include "common/bus/wire_format.hpp"

namespace roadbalance {
namespace {

constexpr std::int32_t kMostMetaParts = 10'000;
constexpr std::int64_t kLongestPeriod_ps = 1'000'000'000'000;  // one scan a second
constexpr std::int32_t kQualityLimit = 1 << 16;                // room for bits of later versions

static_assert(sizeof(wire::scan_block_t::counts) == 4 * wire_format::kScanCounts);
static_assert(sizeof(wire::edge_block_t::codes) == kEdgeBytesPerBlock);
static_assert(sizeof(wire::meta_t::text) == kMetaBytesPerBlock);

template <typename Message>
void put_header(const BlockHeader& header, Message& message) {
  message.node = header.node;
  message.epoch = header.epoch;
  message.sequence = header.sequence;
  message.first_scan = header.first_scan;
  message.scans = header.scans;
  message.time_ns = header.time_ns;
  message.crc32c = 0;
}

template <typename Message>
BlockHeader header_of(const Message& message) {
  return {.node = message.node,
          .epoch = message.epoch,
          .sequence = message.sequence,
          .first_scan = message.first_scan,
          .scans = message.scans,
          .time_ns = message.time_ns};
}

template <typename Message>
void seal_message(BlockKind kind, const Message& message, SealedBlock& out) {
  const std::size_t size = wire_format::size_of<Message>();
  assert(size <= kMaxBlockBytes);
  out.kind = kind;
  out.header = header_of(message);
  out.size = static_cast<std::uint32_t>(size);
  message.encode(out.storage.data(), 0, static_cast<int>(size));
  wire_format::write_crc({out.storage.data(), size});
}

template <typename Message>
Message open_message(BlockKind kind, const SealedBlock& block) {
  assert(block.kind == kind);
  (void)kind;
  const auto message = wire_format::decode<Message>(block.bytes());
  assert(message);
  return *message;
}

template <typename Integer>
bool within(Integer value, Integer low, Integer high) {
  return low <= value && value <= high;
}

bool in_bounds(const BlockHeader& header, std::int32_t lowest_node) {
  return within(header.node, lowest_node, kLastNode) &&
         within<std::int64_t>(header.sequence, 0, kIndexLimit) &&
         within<std::int64_t>(header.first_scan, 0, kIndexLimit) &&
         within<std::int64_t>(header.scans, 0, kIndexLimit - header.first_scan) &&
         within(header.time_ns, -kClockLimit_ns, kClockLimit_ns);
}

template <typename Scan>
bool scan_in_bounds(const Scan& m) {
  return within<std::int64_t>(m.scans, 1, kScansPerBlock) &&
         within<std::int64_t>(m.period_ps, 1, kLongestPeriod_ps) &&
         within(m.overload, 0, (1 << kChannels) - 1) && within(m.quality, 0, kQualityLimit - 1);
}

EdgeBlock edges_of(const wire::edge_block_t& m) {
  EdgeBlock block;
  block.header = header_of(m);
  block.edges = m.edges;
  block.size = m.size;
  std::copy(m.codes, m.codes + kEdgeBytesPerBlock, block.codes.begin());
  return block;
}

bool fields_in_bounds(const wire::edge_block_t& m) {
  return m.scans == 0 && edges_of(m).is_sound();
}

bool fields_in_bounds(const wire::signal_block_t& m) {
  if (m.scans != 0 || !within(m.samples, 0, kSamplesPerBlock)) return false;
  for (int k = 0; k < m.samples; ++k)
    if (!within(m.sample_ns[k], -kClockLimit_ns, kClockLimit_ns) || !std::isfinite(m.value[k]) ||
        !within<std::int16_t>(m.signal[k], 0, kMostSignals - 1))
      return false;
  return true;
}

bool fields_in_bounds(const wire::gap_t& m) {
  return within(m.cause, static_cast<std::int32_t>(GapCause::kRingFull),
                static_cast<std::int32_t>(GapCause::kDeviceGone));
}

bool fields_in_bounds(const wire::meta_t& m) {
  return m.scans == 0 &&
         within(m.kind, static_cast<std::int32_t>(MetaKind::kVehicleToml),
                static_cast<std::int32_t>(MetaKind::kRecordJson)) &&
         within(m.parts, 1, kMostMetaParts) && within(m.part, 0, m.parts - 1) &&
         within(m.size, 0, kMetaBytesPerBlock);
}

bool fields_in_bounds(const wire::end_t& m) {
  return m.scans == 0 && within<std::int64_t>(m.blocks, 0, kIndexLimit) &&
         within<std::int64_t>(m.scans_sealed, 0, kIndexLimit) &&
         within<std::int64_t>(m.scans_missing, 0, kIndexLimit);
}

void take(BlockKind kind, const BlockHeader& header, std::span<const std::uint8_t> bytes, SealedBlock& out) {
  out.kind = kind;
  out.header = header;
  out.size = static_cast<std::uint32_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), out.storage.begin());
}

template <typename Message>
Refusal accept_as(BlockKind kind, std::span<const std::uint8_t> bytes, SealedBlock& out, bool crc_is_good) {
  if (bytes.size() != wire_format::size_of<Message>()) return Refusal::kWrongSize;
  if (!crc_is_good && !ends_with_its_crc(bytes)) return Refusal::kWrongCrc;
  const auto message = wire_format::decode<Message>(bytes);
  if (!message) return Refusal::kUnknownType;
  const BlockHeader header = header_of(*message);
  // Node 0 is the host, which has only descriptions to give.
  const std::int32_t lowest_node = kind == BlockKind::kMeta ? 0 : 1;
  if (!in_bounds(header, lowest_node) || !fields_in_bounds(*message)) return Refusal::kOutOfBounds;
  take(kind, header, bytes, out);
  return Refusal::kNone;
}

Refusal accept_scan(std::span<const std::uint8_t> bytes, SealedBlock& out, bool crc_is_good) {
  if (bytes.size() != wire_format::kScanBytes) return Refusal::kWrongSize;
  if (!crc_is_good && !ends_with_its_crc(bytes)) return Refusal::kWrongCrc;
  const auto fields = wire_format::read_scan_fields(bytes);
  const BlockHeader header = header_of(fields);
  if (!in_bounds(header, 1) || !scan_in_bounds(fields)) return Refusal::kOutOfBounds;
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
  wire::edge_block_t message;
  put_header(block.header, message);
  message.edges = block.edges;
  message.size = block.size;
  std::copy(block.codes.begin(), block.codes.end(), message.codes);
  seal_message(BlockKind::kEdge, message, out);
}

void seal(const SignalBlock& block, SealedBlock& out) {
  wire::signal_block_t message;
  put_header(block.header, message);
  message.samples = block.samples;
  std::copy(block.time_ns.begin(), block.time_ns.end(), message.sample_ns);
  std::copy(block.value.begin(), block.value.end(), message.value);
  std::copy(block.signal.begin(), block.signal.end(), message.signal);
  seal_message(BlockKind::kSignal, message, out);
}

void seal(const GapBlock& block, SealedBlock& out) {
  wire::gap_t message;
  put_header(block.header, message);
  message.cause = static_cast<std::int32_t>(block.cause);
  seal_message(BlockKind::kGap, message, out);
}

void seal(const MetaBlock& block, SealedBlock& out) {
  assert(block.text.size() <= kMetaBytesPerBlock);
  wire::meta_t message{};
  put_header(block.header, message);
  message.kind = static_cast<std::int32_t>(block.kind);
  message.part = block.part;
  message.parts = block.parts;
  message.size = static_cast<std::int32_t>(block.text.size());
  std::copy(block.text.begin(), block.text.end(), message.text);
  seal_message(BlockKind::kMeta, message, out);
}

void seal(const EndBlock& block, SealedBlock& out) {
  wire::end_t message;
  put_header(block.header, message);
  message.blocks = block.blocks;
  message.scans_sealed = block.scans_sealed;
  message.scans_missing = block.scans_missing;
  message.blocks_crc32c = static_cast<std::int32_t>(block.blocks_crc32c);
  seal_message(BlockKind::kEnd, message, out);
}

Refusal accept(std::span<const std::uint8_t> bytes, SealedBlock& out, bool crc_is_good) {
  if (bytes.size() < 8) return Refusal::kWrongSize;
  const std::int64_t fingerprint = wire_format::load_i64(bytes.data());
  if (fingerprint == wire::scan_block_t::getHash()) return accept_scan(bytes, out, crc_is_good);
  if (fingerprint == wire::edge_block_t::getHash())
    return accept_as<wire::edge_block_t>(BlockKind::kEdge, bytes, out, crc_is_good);
  if (fingerprint == wire::gap_t::getHash())
    return accept_as<wire::gap_t>(BlockKind::kGap, bytes, out, crc_is_good);
  if (fingerprint == wire::meta_t::getHash())
    return accept_as<wire::meta_t>(BlockKind::kMeta, bytes, out, crc_is_good);
  if (fingerprint == wire::end_t::getHash())
    return accept_as<wire::end_t>(BlockKind::kEnd, bytes, out, crc_is_good);
  if (fingerprint == wire::signal_block_t::getHash())
    return accept_as<wire::signal_block_t>(BlockKind::kSignal, bytes, out, crc_is_good);
  return Refusal::kUnknownType;
}

ScanBlock decode_scan(const SealedBlock& block) {
  assert(block.kind == BlockKind::kScan);
  const auto fields = wire_format::read_scan_fields(block.bytes());
  ScanBlock result;
  result.header = block.header;
  result.period_ps = fields.period_ps;
  wire_format::read_scan_counts(block.bytes(), result);
  result.overload = fields.overload;
  result.quality = fields.quality;
  return result;
}

EdgeBlock decode_edge(const SealedBlock& block) {
  return edges_of(open_message<wire::edge_block_t>(BlockKind::kEdge, block));
}

SignalBlock decode_signal(const SealedBlock& block) {
  const auto message = open_message<wire::signal_block_t>(BlockKind::kSignal, block);
  SignalBlock result;
  result.header = block.header;
  result.samples = message.samples;
  std::copy(message.sample_ns, message.sample_ns + kSamplesPerBlock, result.time_ns.begin());
  std::copy(message.value, message.value + kSamplesPerBlock, result.value.begin());
  std::copy(message.signal, message.signal + kSamplesPerBlock, result.signal.begin());
  return result;
}

GapBlock decode_gap(const SealedBlock& block) {
  const auto message = open_message<wire::gap_t>(BlockKind::kGap, block);
  return {.header = block.header, .cause = static_cast<GapCause>(message.cause)};
}

MetaBlock decode_meta(const SealedBlock& block) {
  const auto message = open_message<wire::meta_t>(BlockKind::kMeta, block);
  return {.header = block.header,
          .kind = static_cast<MetaKind>(message.kind),
          .part = message.part,
          .parts = message.parts,
          .text = std::string(message.text, message.text + message.size)};
}

EndBlock decode_end(const SealedBlock& block) {
  const auto message = open_message<wire::end_t>(BlockKind::kEnd, block);
  return {.header = block.header,
          .blocks = message.blocks,
          .scans_sealed = message.scans_sealed,
          .scans_missing = message.scans_missing,
          .blocks_crc32c = static_cast<std::uint32_t>(message.blocks_crc32c)};
}

ScanSummary summary_of(const SealedBlock& block) {
  assert(block.kind == BlockKind::kScan);
  const auto fields = wire_format::read_scan_fields(block.bytes());
  return {.period_ps = fields.period_ps, .overload = fields.overload, .quality = fields.quality};
}

std::span<const std::uint8_t> encoded_counts(const SealedBlock& block) {
  assert(block.kind == BlockKind::kScan);
  const auto rows = static_cast<std::size_t>(block.header.scans);
  return block.bytes().subspan(wire_format::kScanCountsAt, rows * kChannels * sizeof(std::int32_t));
}

}  // namespace roadbalance
