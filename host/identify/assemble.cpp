#include "host/identify/assemble.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "common/bus/codec.hpp"

namespace roadbalance {
Assembler::Assembler(const VehicleConfig& vehicle, const SensorMap& sensors, Emit emit, double longest_wait_s)
    : longest_wait_s_(longest_wait_s), emit_(std::move(emit)) {
  std::vector<const NodeConfig*> used;
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
      const WheelConfig* const encoder = vehicle.wheel_at(node, line);
      if (!encoder) continue;
      const int wheel = vehicle.place_of(*encoder);
      map.from_counts(sine_row(wheel), kAccelerations + 2 * line) = 1.0 / kFullScaleCounts;
      map.from_counts(cosine_row(wheel), kAccelerations + 2 * line + 1) = 1.0 / kFullScaleCounts;
      map.wheel[static_cast<std::size_t>(line)] = wheel;
    }
    if (map.from_counts.isZero()) continue;  // nothing of it is used
    used.push_back(&node);
    maps_.push_back(map);
  }
  for (const NodeConfig* node : used) streams_.emplace_back(node->id, used.size() == 1, delays_of(*node));
}

GridStream* Assembler::stream_of(std::int32_t node) {
  const auto found = std::find_if(streams_.begin(), streams_.end(),
                                  [&](const GridStream& stream) { return stream.node() == node; });
  return found == streams_.end() ? nullptr : &*found;
}

void Assembler::consume(const SealedBlock& block) {
  if (block.kind != BlockKind::kScan || block.header.scans == 0) return;
  GridStream* const stream = stream_of(block.header.node);
  if (!stream) return;
  stream->take(decode_scan(block), grid_);
  emit(*stream);
}

void Assembler::consume(const ClockFit& fit) {
  GridStream* const stream = stream_of(fit.node);
  if (!stream) return;
  stream->take(fit, grid_);
  emit(*stream);
}

void Assembler::emit(const GridStream& changed) {
  emit_common_rows();
  drop_what_nobody_meets();
  if (no_common_time_.empty() || stream_of_obstacle_ == changed.node()) {
    no_common_time_ = changed.obstacle();
    stream_of_obstacle_ = changed.node();
  }
}

/// Removes rows that must not be used from the front.
void Assembler::drop_unusable(GridStream& stream, const NodeMap& map) {
  while (!stream.rows.empty()) {
    GridRows& front = stream.rows.front();
    // It must not be forgotten where the row that bore it is passed over.
    stream.restarted = std::exchange(front.restart, false) || stream.restarted;
    if ((front.overload & map.overload_mask) == 0 && stream.row < front.rows) return;
    stream.rows.pop_front();
    stream.row = 0;
  }
}

/// A node that stays away must not make the others' rows pile up.
void Assembler::drop_what_nobody_meets() {
  const double longest =
      longest_wait_s_ * 1e12 / static_cast<double>(std::max<std::int64_t>(grid_.period_ps, 1));
  for (auto& stream : streams_)
    while (!stream.rows.empty() &&
           static_cast<double>(stream.rows.back().first_index - stream.rows.front().first_index) > longest) {
      stream.rows.pop_front();
      stream.row = 0;
    }
}

/// Adds one node's share to all columns of the run.
void Assembler::add_rows(const GridStream& stream, const NodeMap& map) {
  const GridRows& front = stream.rows.front();
  auto from_counts = map.from_counts;
  for (std::size_t line = 0; line < kEncoderLines; ++line)
    if (map.wheel[line] && (front.quality & quality_no_reference(static_cast<int>(line))) != 0)
      from_counts.middleRows<2>(cosine_row(*map.wheel[line])).setZero();
  for (Eigen::Index row = 0; row < run_.samples.cols(); ++row) {
    const auto& counts = front.counts[static_cast<std::size_t>(stream.row + row)];
    run_.samples.col(row) +=
        map.at_zero_counts +
        from_counts * Eigen::Map<const Eigen::Matrix<float, kChannels, 1>>(counts.data()).cast<double>();
  }
}

void Assembler::emit_common_rows() {
  const auto next_index = [](const GridStream& stream) {
    return stream.rows.front().first_index + stream.row;
  };
  for (;;) {
    std::int64_t newest = 0;
    bool aligned = true;
    for (std::size_t n = 0; n < streams_.size(); ++n) {
      drop_unusable(streams_[n], maps_[n]);
      if (streams_[n].rows.empty()) return;
      const std::int64_t index = next_index(streams_[n]);
      aligned = aligned && (n == 0 || index == newest);
      newest = n == 0 ? index : std::max(newest, index);
    }
    if (!aligned) {  // rows that another node lacks
      for (auto& stream : streams_) {
        const std::int64_t left = stream.rows.front().rows - stream.row;
        stream.row += std::clamp<std::int64_t>(newest - next_index(stream), 0, left);
      }
      continue;
    }
    std::int64_t rows = GridRows::kMost;
    bool restart = newest != expected_;
    for (auto& stream : streams_) {
      rows = std::min(rows, stream.rows.front().rows - stream.row);
      restart = std::exchange(stream.restarted, false) || restart;
    }
    run_.first_index = newest;
    run_.restart = restart;
    const GridStream& first = streams_.front();
    run_.time_ns = first.rows.front().time_ns + (first.row + rows - 1) * grid_.period_ps / 1000;
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
