#include "host/analysis/twin/sensor_samples.hpp"

#include <utility>

#include "common/dsp/decimation.hpp"
#include "host/analysis/identify/assemble.hpp"
#include "host/analysis/identify/decimate.hpp"

namespace roadbalance {

SensorSamples::SensorSamples(const VehicleConfig& vehicle, const TwinChannels& channels, Emit emit)
    : rows_(Assembler::kLongestWait_s),
      at_zero_counts_(Eigen::VectorXd::Zero(std::ssize(channels.channel) + 2 * kWheels)),
      behind_(decimation_taps(decimation_factor(vehicle)).size() / 2),
      low_pass_(at_zero_counts_.size(), decimation_factor(vehicle),
                decimation_taps(decimation_factor(vehicle))),
      emit_(std::move(emit)) {
  const auto sensors = std::ssize(channels.channel);
  std::vector<std::pair<const NodeConfig*, std::int32_t>> used;
  for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
    const NodeConfig& node = vehicle.node[n];
    NodeMap map{Eigen::MatrixXd::Zero(at_zero_counts_.size(), kChannels), {}};
    std::int32_t unusable = 0;
    for (Eigen::Index s = 0; s < sensors; ++s) {
      const TwinChannels::One& one = channels.channel[static_cast<std::size_t>(s)];
      if (one.node != static_cast<int>(n)) continue;
      const ChannelConfig& channel = node.channel[static_cast<std::size_t>(one.channel)];
      map.from_counts(s, one.channel) = channel.scale_m_s2_per_count;
      at_zero_counts_(s) = channel.to_si(0.0);
      unusable |= 1 << one.channel;
    }
    for (int line = 0; line < kEncoderLines; ++line) {
      const WheelConfig* const encoder = vehicle.wheel_at(node, line);
      if (!encoder) continue;
      const int wheel = vehicle.place_of(*encoder);
      map.from_counts(sensors + 2 * wheel + 1, kAccelerations + 2 * line) = 1.0 / kFullScaleCounts;
      map.from_counts(sensors + 2 * wheel, kAccelerations + 2 * line + 1) = 1.0 / kFullScaleCounts;
      map.wheel[static_cast<std::size_t>(line)] = wheel;
    }
    if (map.from_counts.isZero()) continue;
    maps_.push_back(std::move(map));
    used.emplace_back(&node, unusable);
  }
  for (const auto& [node, unusable] : used) rows_.add(*node, used.size() == 1, unusable);
}

double SensorSamples::rate_hz(const VehicleConfig& vehicle) {
  return vehicle.node.front().rate_hz / decimation_factor(vehicle);
}

void SensorSamples::consume(const SealedBlock& block) {
  if (rows_.take(block)) take_runs();
}

void SensorSamples::consume(const ClockFit& fit) {
  if (rows_.take(fit)) take_runs();
}

void SensorSamples::take_runs() {
  while (const auto run = rows_.next()) {
    samples_.resize(at_zero_counts_.size(), run->rows);
    samples_.colwise() = at_zero_counts_;
    for (std::size_t n = 0; n < maps_.size(); ++n) add_node(rows_.streams()[n], maps_[n], *run);
    decimate(*run);
    rows_.use(*run);
  }
  rows_.drop_what_nobody_meets();
}

void SensorSamples::add_node(const GridStream& stream, const NodeMap& map, const CommonRows::Run& run) {
  const GridRows& front = stream.rows.front();
  Eigen::MatrixXd from_counts = map.from_counts;
  for (std::size_t line = 0; line < kEncoderLines; ++line)
    if (map.wheel[line] && (front.quality & quality_no_reference(static_cast<int>(line))) != 0)
      from_counts.middleRows<2>(from_counts.rows() - 2 * kWheels + 2 * *map.wheel[line]).setZero();
  const Eigen::Map<const Eigen::Matrix<float, kChannels, Eigen::Dynamic>> counts(
      front.counts[static_cast<std::size_t>(stream.row)].data(), kChannels, run.rows);
  samples_.noalias() += from_counts * counts.cast<double>();
}

void SensorSamples::decimate(const CommonRows::Run& run) {
  if (run.restart) {
    low_pass_.restart(run.first_index);
    restart_ = true;
  }
  for (Eigen::Index i = 0; i < run.rows; ++i) {
    if (!low_pass_.add(samples_.col(i))) continue;
    sample_.values = low_pass_.output();
    sample_.restart = std::exchange(restart_, false);
    sample_.time_ns = rows_.grid().time_ns(run.first_index + i - behind_);
    emit_(sample_);
  }
}

}  // namespace roadbalance
