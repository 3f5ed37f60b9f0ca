#include "firmware/backends/usb/board_reader.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/backends/usb/board_setup.hpp"

namespace roadbalance {

ScanNumbering::Number ScanNumbering::number(std::int64_t index_in_run, NodeTime time,
                                            double period_s) noexcept {
  Number number;
  if (first_of_run_ && any_) {
    const auto passed = std::llround(to_seconds(time - last_time_) / period_s_);
    offset_ = last_index_ + std::max<std::int64_t>(passed, 1) - index_in_run;
    number.after_absence = true;
  }
  first_of_run_ = false;
  any_ = true;
  number.index = index_in_run + offset_;
  last_index_ = number.index;
  last_time_ = time;
  period_s_ = period_s;
  return number;
}

namespace {

using board::PacketEdgeKind;

EdgeKind kind_of(PacketEdgeKind kind) {
  switch (kind) {
    case PacketEdgeKind::kToothForward:
      return EdgeKind::kTooth;
    case PacketEdgeKind::kZeroMark:
      return EdgeKind::kZeroMark;
    case PacketEdgeKind::kToothBackward:
      return EdgeKind::kToothBackward;
    case PacketEdgeKind::kLost:
      break;
  }
  return EdgeKind::kLost;
}

/// 0.9 of full scale at the converter becomes 1.
std::int32_t reference_counts(std::int32_t counts) {
  return static_cast<std::int32_t>(std::lround(counts * (1000.0 / kReferencePerMille)));
}

/// Stamp of the last thing in a packet; of an empty one when it was made.
std::uint64_t latest_ticks(const board::PacketView& packet) {
  const board::PacketHeader& header = packet.header();
  std::int64_t behind = header.scans > 0 ? (header.scans - std::int64_t{1}) * header.ticks_per_scan : 0;
  if (header.edges > 0)
    behind = std::max<std::int64_t>(behind, packet.edge(header.edges - std::size_t{1}).offset_ticks);
  return header.base_ticks + static_cast<std::uint64_t>(behind);
}

}  // namespace

BoardReader::BoardReader(const std::vector<DeviceReport*>& reports, double rate_hz, std::size_t channels,
                         std::array<bool, kEncoderLines> lines)
    : report_(reports),
      rate_hz_(rate_hz),
      channels_(channels),
      lines_(lines),
      pair_(reports.size()),
      edges_(*reports.front()) {
  for (DeviceReport* report : reports) stream_.emplace_back(*report);
}

void BoardReader::take(const BoardDelivery& delivery) noexcept {
  if (delivery.kind == BoardDelivery::Kind::kRunBegin) return begin_run(delivery.run);
  if (delivery.board >= stream_.size() || !clock_[delivery.board]) return;
  if (delivery.kind == BoardDelivery::Kind::kExchange)
    return clock_[delivery.board]->compare(delivery.exchange);
  const auto transfer = std::span(delivery.bytes).first(delivery.size);
  const auto packet = stream_[delivery.board].take(transfer, delivery.dropped);
  const bool is_used = packet && take_packet(delivery.board, *packet, delivery.arrival);
  flow_[delivery.board].take(delivery.arrival, is_used && packet->content.header().scans > 0,
                             delivery.dropped == 0);
}

void BoardReader::begin_run(const RunBegin& run) noexcept {
  for (std::size_t k = 0; k < stream_.size(); ++k) {
    stream_[k].start(run.token, run.ticks_per_scan[k], run.tick_hz[k], run.begin[k].ticks);
    clock_[k].emplace(run.tick_hz[k], run.begin[k]);
    flow_[k].start_run();
  }
  pair_.start(run.tick_hz, rate_hz_);
  numbering_.start_run();
  token_ = run.token;
  ticks_per_scan_ = run.ticks_per_scan[0];
  edges_missing_ = any_run_;
  any_run_ = true;
}

/// False: its stamps cannot be, and it is not used.
bool BoardReader::take_packet(std::size_t board, const PacketStream::Packet& packet,
                              NodeTime arrival) noexcept {
  BoardClock& clock = *clock_[board];
  const BoardInstant latest{latest_ticks(packet.content), arrival};
  if (!clock.is_possible(latest)) {
    stream_[board].distrust();
    if (board == 0) edges_missing_ = true;  // the stream goes on behind it as if it had been used
    report_[board]->count(DeviceCounter::kPacketsRefused);
    return false;
  }
  clock.hear(latest);
  if (board == 0) take_edges(packet);
  const board::PacketHeader& header = packet.content.header();
  for (std::size_t k = 0; k < header.scans; ++k) {
    const std::uint64_t ticks = header.base_ticks + k * std::uint64_t{header.ticks_per_scan};
    const bool kept = pair_.add(board, {.index = static_cast<std::int64_t>(header.first_scan + k),
                                        .ticks = ticks,
                                        .time = clock.time(ticks),
                                        .content = packet.content.scan(k)});
    if (!kept) report_[1 - board]->count(DeviceCounter::kPartnerLate);
    if (board == 0) last_scan_time_ = clock.time(ticks);
  }
  return true;
}

void BoardReader::take_edges(const PacketStream::Packet& packet) noexcept {
  const board::PacketHeader& header = packet.content.header();
  // A scan is converted up to half a microsecond before the instant in its packet, so that an edge behind it
  // can be stamped before that; it must not come with a time whose scan has gone.
  const auto time_of = [&](std::int64_t offset_ticks) {
    return std::max(clock_[0]->time(header.base_ticks + static_cast<std::uint64_t>(offset_ticks)),
                    last_scan_time_ + NodeClock::duration(1));
  };
  if (packet.after_missing) edges_missing_ = true;
  if (edges_missing_)
    mark_lost(time_of(header.edges > 0 ? std::min(0, packet.content.edge(0).offset_ticks) : 0));
  edges_missing_ = false;
  for (std::size_t k = 0; k < header.edges; ++k) {
    const board::PacketEdge edge = packet.content.edge(k);
    if (lines_[edge.line]) edges_.add({time_of(edge.offset_ticks), edge.line, kind_of(edge.kind)});
  }
}

void BoardReader::mark_lost(NodeTime time) noexcept {
  for (std::size_t line = 0; line < lines_.size(); ++line)
    if (lines_[line]) edges_.add({time, static_cast<std::uint8_t>(line), EdgeKind::kLost});
}

Scan BoardReader::scan_of(const BoardPair::Common& common) noexcept {
  const board::PacketScan& first = common.first->content;
  Scan scan;
  scan.time = common.first->time;
  const auto number =
      numbering_.number(common.first->index, scan.time, clock_[0]->tick_s() * ticks_per_scan_);
  scan.index = number.index;
  scan.after_absence = number.after_absence;
  const std::size_t inputs = common.second ? kInputsOfPair : board::kInputChannels;
  for (std::size_t k = 0; k < channels_; ++k) {
    const board::PacketScan& from = k < inputs ? first : common.second->content;
    scan.counts[k] = from.counts[k % inputs];
    scan.overload |= static_cast<std::uint32_t>(from.overload >> (k % inputs) & 1) << k;
  }
  for (std::size_t k = 0; k < kReferences; ++k) {
    scan.references[k] = reference_counts(first.counts[board::kInputChannels + k]);
    const std::size_t channel = board::kInputChannels + k;
    scan.overload |= static_cast<std::uint32_t>(first.overload >> channel & 1) << channel;
  }
  return scan;
}

bool BoardReader::hand_over(std::span<Scan> scans, std::span<Edge> edges, Read& read) noexcept {
  while (true) {
    const BoardPair::Common common = pair_.front();
    const Edge* edge = edges_.front();
    if (edge && (!common.first || edge->time <= common.first->time)) {
      if (read.edges == edges.size()) return false;
      edges[read.edges++] = *edge;
      edges_.drop();
    } else if (common.first) {
      if (read.scans == scans.size()) return false;
      scans[read.scans++] = scan_of(common);
      pair_.drop();
    } else {
      return true;
    }
  }
}

}  // namespace roadbalance
