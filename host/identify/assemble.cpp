#include "host/identify/assemble.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

/// Samples may lie this far, in periods, from the common grid: 0.02 periods at 2 kHz are 0.06 degrees at 18
/// Hz.
constexpr double kGridTolerance = 0.02;

}  // namespace

Assembler::Assembler(const VehicleConfig& vehicle, Emit emit) : emit_(std::move(emit)) {
  const SensorMap sensors = SensorMap::from(vehicle);
  for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
    const NodeConfig& node = vehicle.node[n];
    NodeMap map{decltype(NodeMap::from_counts)::Zero(), SignalVector::Zero(), 0, 0};
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
      map.reference_mask |= line == 0 ? kQualityNoReference0 : kQualityNoReference1;
    }
    if (map.overload_mask == 0 && map.reference_mask == 0) continue;  // nothing of it is used
    streams_.push_back({node.id, {}, 0});
    maps_.push_back(map);
  }
}

void Assembler::consume(const SealedBlock& block) {
  if (block.kind != BlockKind::kScan || block.header.scans == 0) return;
  const auto stream = std::find_if(streams_.begin(), streams_.end(),
                                   [&](const Stream& s) { return s.id == block.header.node; });
  if (stream == streams_.end()) return;
  stream->blocks.push_back(decode_scan(block));
  if (!origin_ns_) {
    origin_ns_ = block.header.time_ns;
    period_ps_ = stream->blocks.back().period_ps;
  }
  emit_common_rows();
}

/// Removes blocks that must not be used from the front.
void Assembler::drop_unusable(Stream& stream, const NodeMap& map) const {
  while (!stream.blocks.empty()) {
    const ScanBlock& block = stream.blocks.front();
    const bool usable =
        (block.overload & map.overload_mask) == 0 && (block.quality & map.reference_mask) == 0;
    if (usable && stream.row < block.header.scans) return;
    stream.blocks.pop_front();
    stream.row = 0;
  }
}

std::int64_t Assembler::grid_index(const Stream& stream) const {
  const double ns = static_cast<double>(stream.blocks.front().row_time_ns(stream.row) - *origin_ns_);
  const double periods = ns * 1000.0 / static_cast<double>(period_ps_);
  const double index = std::round(periods);
  if (std::abs(periods - index) > kGridTolerance)
    throw std::runtime_error("node " + std::to_string(stream.id) + ": its samples lie " +
                             std::to_string(std::abs(periods - index)) +
                             " sample periods off the grid of the other nodes");
  return static_cast<std::int64_t>(index);
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
      Stream& stream = streams_[n];
      for (std::int64_t row = 0; row < rows; ++row) {
        const auto& counts = stream.blocks.front().counts[static_cast<std::size_t>(stream.row + row)];
        run_.samples.col(row) +=
            maps_[n].at_zero_counts +
            maps_[n].from_counts *
                Eigen::Map<const Eigen::Matrix<std::int32_t, kChannels, 1>>(counts.data()).cast<double>();
      }
      stream.row += rows;
    }
    expected_ = newest + rows;
    emit_(run_);
  }
}

}  // namespace roadbalance
