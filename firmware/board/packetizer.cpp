#include "firmware/board/packetizer.hpp"

#include <algorithm>
#include <cstring>

namespace roadbalance::board {
namespace {

constexpr std::size_t kMostEdges = (kMaxPacketBytes - packet_bytes(0, 0)) / kEdgeBytes;
constexpr std::uint32_t kTolerancesPerSecond = 2'000'000;

// A packet's edges lie within 2^31 ticks of its base: an older one begins a packet of its own.
constexpr std::uint64_t kFarthestTicks = INT32_MAX;

}  // namespace

void Packetizer::start(const Setup& setup, std::uint64_t now_ticks) {
  setup_ = setup;
  limit_ticks_ = static_cast<std::uint32_t>(std::uint64_t{setup.tick_hz} * setup.limit_us / 1'000'000);
  silence_ticks_ = setup.tick_hz / 1000 * kSilenceLimitMs;
  tolerance_ticks_ = setup.tick_hz / kTolerancesPerSecond;
  sequence_ = 0;
  next_scan_ = 0;
  sent_ticks_ = now_ticks;
}

bool Packetizer::is_due(std::uint64_t now_ticks, SampleRing& samples, EncoderCapture& encoders) const {
  const std::size_t scans = samples.queue().size();
  const std::size_t edges = encoders.queue().size();
  if (packet_bytes(scans, edges) > kMaxPacketBytes) return true;
  // A stamp can be later than `now`, which was read before.
  const auto age = [&](std::uint64_t ticks) { return now_ticks > ticks ? now_ticks - ticks : 0; };
  if (scans > 0 && age(samples.queue()[0].ticks) >= limit_ticks_) return true;
  if (edges > 0 && age(encoders.queue()[0].ticks) >= limit_ticks_) return true;
  return age(sent_ticks_) >= silence_ticks_;
}

bool Packetizer::continues(const StoredScan& first, const StoredScan& scan, std::size_t k) const {
  // A scan's index is made of its time, so that a jump of the one is a jump of the other.
  const std::uint64_t expected = first.ticks + k * std::uint64_t{setup_.ticks_per_scan};
  return scan.ticks - expected + tolerance_ticks_ <= 2 * tolerance_ticks_;
}

// The most scans whose every earlier edge fits, too; if not one does, then the most edges.
Packetizer::Content Packetizer::fitting(SampleRing& samples, EncoderCapture& encoders) const {
  // Edges come before the scan that follows them: a scan that is seen here has all its edges.
  const std::size_t scans = samples.queue().size();
  const std::size_t edges = encoders.queue().size();
  Content fits;
  std::size_t before = 0;
  for (std::size_t k = 0; k < scans; ++k) {
    const StoredScan& scan = samples.queue()[k];
    if (!continues(samples.queue()[0], scan, k)) break;
    while (before < edges && encoders.queue()[before].ticks <= scan.ticks) ++before;
    if (packet_bytes(k + 1, before) > kMaxPacketBytes) break;
    fits = {k + 1, before};
  }
  if (fits.edges > 0 && samples.queue()[0].ticks > encoders.queue()[0].ticks + kFarthestTicks) fits.scans = 0;
  if (fits.scans > 0) return fits;
  fits.edges = 0;
  while (fits.edges < std::min(edges, kMostEdges) &&
         encoders.queue()[fits.edges].ticks <= encoders.queue()[0].ticks + kFarthestTicks)
    ++fits.edges;
  return fits;
}

PacketHeader Packetizer::header(std::uint64_t now_ticks, SampleRing& samples, EncoderCapture& encoders,
                                const Content& content) const {
  PacketHeader header;
  header.token = setup_.token;
  header.sequence = sequence_;
  header.first_scan = content.scans > 0 ? samples.queue()[0].index : next_scan_;
  header.base_ticks = content.scans > 0   ? samples.queue()[0].ticks
                      : content.edges > 0 ? encoders.queue()[0].ticks
                                          : now_ticks;
  header.ticks_per_scan = setup_.ticks_per_scan;
  header.scans = static_cast<std::uint16_t>(content.scans);
  header.edges = static_cast<std::uint16_t>(content.edges);
  if (header.first_scan != next_scan_) header.flags |= kScansLostBefore;
  if (setup_.pattern) header.flags |= kPatternOn;
  header.scans_lost = samples.lost();
  header.scans_missed = samples.missed();
  header.edges_lost = encoders.lost();
  header.overloads = samples.overloads();
  header.glitches = samples.glitches();
  return header;
}

std::size_t Packetizer::next(std::uint64_t now_ticks, SampleRing& samples, EncoderCapture& encoders,
                             std::uint32_t locked, std::span<std::uint8_t> packet) {
  if (packet.size() < kMaxPacketBytes || !is_due(now_ticks, samples, encoders)) return 0;
  const Content content = fitting(samples, encoders);
  PacketHeader head = header(now_ticks, samples, encoders, content);
  head.flags |= (locked & 3u) * kLocked0;

  std::size_t at = kHeaderBytes;
  for (std::size_t k = 0; k < content.scans; ++k, at += kScanBytes) {
    const StoredScan& scan = samples.queue()[k];
    std::memcpy(&packet[at], scan.bytes.data(), kScanBytes);
    if ((scan.bytes[0] | scan.bytes[1]) != 0) head.flags |= kOverload;
  }
  for (std::size_t k = 0; k < content.edges; ++k, at += kEdgeBytes) {
    const CapturedEdge& edge = encoders.queue()[k];
    if (edge.kind == PacketEdgeKind::kLost) head.flags |= kEdgesLostHere;
    const auto offset = static_cast<std::int32_t>(static_cast<std::int64_t>(edge.ticks - head.base_ticks));
    encode_edge({offset, edge.line, edge.kind, edge.lost}, packet.subspan(at).first<kEdgeBytes>());
  }
  encode_header(head, packet.first<kHeaderBytes>());
  seal_packet(packet.first(at + kCrcBytes));

  samples.queue().drop(content.scans);
  encoders.queue().drop(content.edges);
  next_scan_ = head.first_scan + content.scans;
  sent_ticks_ = now_ticks;
  ++sequence_;
  return at + kCrcBytes;
}

}  // namespace roadbalance::board
