#include "host/identify/assemble.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

/// Samples may lie this far, in periods, from the common grid: 0.02 periods at 2 kHz are 0.06 degrees at 18
/// Hz.
constexpr double kGridTolerance = 0.02;

}  // namespace

Assembler::Assembler(const VehicleConfig& vehicle, Emit emit, double longest_wait_s)
    : longest_wait_s_(longest_wait_s), emit_(std::move(emit)) {
  const SensorMap sensors = SensorMap::from(vehicle);
  for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
    const NodeConfig& node = vehicle.node[n];
    NodeMap map{decltype(NodeMap::from_counts)::Zero(), SignalVector::Zero(), 0, {}};
    for (std::size_t s = 0; s < sensors.input.size(); ++s) {
      if (sensors.input[s].node != static_cast<int>(n)) continue;
      const int c = sensors.input[s].channel;
      const ChannelConfig& channel = node.channel[static_cast<std::size_t>(c)];
      const Vector7 weights = sensors.pseudo_inverse.col(static_cast<Eigen::Index>(s));
      map.from_counts.col(c).head<kCoordinates>() = weights * channel.scale_m_s2_per_count;
      map.at_zero_counts.head<kCoordinates>() += weights * channel.to_si(0.0);
      map.overload_mask |= 1 << c;
    }
    for (int line = 0; line < kEncoderLines; ++line) {
      const auto wheel = vehicle.wheel_at(node, line);
      if (!wheel) continue;
      map.from_counts(sine_row(*wheel), kAccelerations + 2 * line) = 1.0 / kFullScaleCounts;
      map.from_counts(cosine_row(*wheel), kAccelerations + 2 * line + 1) = 1.0 / kFullScaleCounts;
      map.wheel[static_cast<std::size_t>(line)] = wheel;
    }
    if (map.from_counts.isZero()) continue;  // nothing of it is used
    streams_.push_back({node.id, {}, 0});
    maps_.push_back(map);
  }
}

void Assembler::consume(const SealedBlock& block) {
  if (block.kind != BlockKind::kScan || block.header.scans == 0) return;
  const auto stream = std::find_if(streams_.begin(), streams_.end(),
                                   [&](const Stream& s) { return s.id == block.header.node; });
  if (stream == streams_.end()) return;
  ScanBlock scans = decode_scan(block);
  if (!origin_ns_) {
    origin_ns_ = block.header.time_ns;
    period_ps_ = scans.period_ps;
  }
  if (!on_grid(scans)) return;
  stream->blocks.push_back(std::move(scans));
  emit_common_rows();
  drop_what_nobody_meets();
}

/// Notes and refuses a block whose samples lie between those of the grid.
bool Assembler::on_grid(const ScanBlock& block) {
  const double periods =
      static_cast<double>(block.header.time_ns - *origin_ns_) * 1000.0 / static_cast<double>(period_ps_);
  const double off = std::abs(periods - std::round(periods));
  constexpr double kLargest = 1e15;  // still exact as a double
  if (off <= kGridTolerance && std::abs(periods) < kLargest && block.period_ps == period_ps_) return true;
  off_grid_ = "node " + std::to_string(block.header.node) + ": its samples lie " + std::to_string(off) +
              " sample periods off the grid of the others, or have another rate";
  return false;
}

/// Removes blocks that must not be used from the front.
void Assembler::drop_unusable(Stream& stream, const NodeMap& map) {
  while (!stream.blocks.empty()) {
    const ScanBlock& block = stream.blocks.front();
    if ((block.overload & map.overload_mask) == 0 && stream.row < block.header.scans) return;
    stream.blocks.pop_front();
    stream.row = 0;
  }
}

/// A node that stays away must not make the others' blocks pile up.
void Assembler::drop_what_nobody_meets() {
  for (auto& stream : streams_) {
    const auto waits_s = [&] {
      return 1e-9 *
             static_cast<double>(stream.blocks.back().header.time_ns - stream.blocks.front().header.time_ns);
    };
    while (!stream.blocks.empty() && waits_s() > longest_wait_s_) {
      stream.blocks.pop_front();
      stream.row = 0;
    }
  }
}

std::int64_t Assembler::grid_index(const Stream& stream) const {
  const auto ns = static_cast<double>(stream.blocks.front().header.time_ns - *origin_ns_);
  return std::llround(ns * 1000.0 / static_cast<double>(period_ps_)) + stream.row;
}

/// Adds one node's share to all columns of the run.
void Assembler::add_rows(const Stream& stream, const NodeMap& map) {
  const ScanBlock& block = stream.blocks.front();
  auto from_counts = map.from_counts;
  for (std::size_t line = 0; line < kEncoderLines; ++line)
    if (map.wheel[line] && (block.quality & quality_no_reference(static_cast<int>(line))) != 0)
      from_counts.middleRows<2>(cosine_row(*map.wheel[line])).setZero();
  for (Eigen::Index row = 0; row < run_.samples.cols(); ++row) {
    const auto& counts = block.counts[static_cast<std::size_t>(stream.row + row)];
    run_.samples.col(row) +=
        map.at_zero_counts +
        from_counts *
            Eigen::Map<const Eigen::Matrix<std::int32_t, kChannels, 1>>(counts.data()).cast<double>();
  }
}

void Assembler::emit_common_rows() {
  for (;;) {
    std::int64_t newest = 0;
    bool aligned = true;
    for (std::size_t n = 0; n < streams_.size(); ++n) {
      drop_unusable(streams_[n], maps_[n]);
      if (streams_[n].blocks.empty()) return;
      const std::int64_t index = grid_index(streams_[n]);
      aligned = aligned && (n == 0 || index == newest);
      newest = n == 0 ? index : std::max(newest, index);
    }
    if (!aligned) {  // rows that another node lacks
      for (auto& stream : streams_) {
        const std::int64_t left = stream.blocks.front().header.scans - stream.row;
        stream.row += std::clamp<std::int64_t>(newest - grid_index(stream), 0, left);
      }
      continue;
    }
    std::int64_t rows = kScansPerBlock;
    for (const auto& stream : streams_)
      rows = std::min(rows, stream.blocks.front().header.scans - stream.row);
    run_.first_index = newest;
    run_.restart = newest != expected_;
    run_.time_ns = streams_.front().blocks.front().row_time_ns(streams_.front().row + rows - 1);
    run_.samples.setZero(kSignals, rows);
    for (std::size_t n = 0; n < streams_.size(); ++n) {
      add_rows(streams_[n], maps_[n]);
      streams_[n].row += rows;
    }
    expected_ = newest + rows;
    emit_(run_);
  }
}

}  // namespace roadbalance
