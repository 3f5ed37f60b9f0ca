#include "host/analysis/identify/assemble.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/vehicle/sensor_map.hpp"

namespace roadbalance {
namespace {

/// The wheel whose road a channel measures; nothing: it does not.
std::optional<int> road_wheel(const ChannelConfig& channel) {
  if (channel.role != ChannelRole::kRoad) return std::nullopt;
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (channel.mount == kWheelNames[static_cast<std::size_t>(wheel)]) return wheel;
  return std::nullopt;
}

}  // namespace

bool measures_road(const VehicleConfig& vehicle) {
  std::array<int, kWheels> channels{};
  for (const NodeConfig& node : vehicle.node)
    for (const ChannelConfig& channel : node.channel)
      if (const auto wheel = road_wheel(channel)) ++channels[static_cast<std::size_t>(*wheel)];
  return std::all_of(channels.begin(), channels.end(), [](int count) { return count == 1; });
}

void Assembler::add_road(NodeMap& map, const NodeConfig& node) const {
  map.road_from_counts.setZero();
  map.road_at_zero_counts.setZero();
  for (std::size_t c = 0; road_measured_ && c < node.channel.size(); ++c) {
    const auto wheel = road_wheel(node.channel[c]);
    if (!wheel) continue;
    map.road_from_counts(*wheel, static_cast<Eigen::Index>(c)) = node.channel[c].scale_m_s2_per_count;
    map.road_at_zero_counts(*wheel) = node.channel[c].to_si(0.0);
    map.overload_mask |= 1 << c;
  }
}

Assembler::Assembler(const VehicleConfig& vehicle, const SensorMap& sensors, Emit emit, double longest_wait_s)
    : rows_(longest_wait_s),
      inputs_(std::ssize(sensors.input)),
      road_measured_(measures_road(vehicle)),
      emit_(std::move(emit)) {
  std::vector<const NodeConfig*> used;
  for (std::size_t n = 0; n < vehicle.node.size(); ++n) {
    const NodeConfig& node = vehicle.node[n];
    NodeMap map{};
    map.from_counts.setZero();
    map.at_zero_counts.setZero();
    add_road(map, node);
    for (std::size_t s = 0; s < sensors.input.size(); ++s) {
      if (sensors.input[s].node != static_cast<int>(n)) continue;
      const int c = sensors.input[s].channel;
      const ChannelConfig& channel = node.channel[static_cast<std::size_t>(c)];
      const Vector7 weights = sensors.pseudo_inverse.col(static_cast<Eigen::Index>(s));
      map.from_counts.col(c).head<kCoordinates>() = weights * channel.scale_m_s2_per_count;
      map.at_zero_counts.head<kCoordinates>() += weights * channel.to_si(0.0);
      map.readings.push_back(
          {static_cast<Eigen::Index>(s), c, channel.scale_m_s2_per_count, channel.to_si(0.0)});
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
    if (map.from_counts.isZero() && map.road_from_counts.isZero()) continue;  // nothing of it is used
    for (Eigen::Index c = 0; c < kChannels; ++c)
      if ((map.from_counts.col(c).array() != 0.0).any()) map.used.push_back(c);
    used.push_back(&node);
    maps_.push_back(map);
  }
  for (std::size_t n = 0; n < used.size(); ++n) {
    const std::int32_t mask = maps_[n].overload_mask;
    rows_.add(*used[n], used.size() == 1, mask | mask << kChannels);
    clipped_.emplace_back(*used[n], mask);
  }
}

void Assembler::consume(const SealedBlock& block) {
  if (block.kind != BlockKind::kScan) return;
  const auto of = std::ranges::find(clipped_, block.header.node, &ClippedChannels::node);
  if (of == clipped_.end()) return;
  ScanBlock scans = decode_scan(block);
  const ClippedChannels::Found found = of->add(scans);
  scans.overload |= found.reached | found.news << kChannels;
  if (rows_.take(scans)) emit();
}

std::vector<std::string> Assembler::clipped() const {
  std::vector<std::string> all;
  for (const ClippedChannels& node : clipped_)
    for (std::string& sentence : node.sentences()) all.push_back(std::move(sentence));
  return all;
}

void Assembler::consume(const ClockFit& fit) {
  if (rows_.take(fit)) emit();
}

void Assembler::emit() {
  while (const auto run = rows_.next()) {
    emit_run(*run);
    rows_.use(*run);
  }
  rows_.drop_what_nobody_meets();
}

/// Adds one node's share to all columns of the run.
void Assembler::add_rows(const GridStream& stream, const NodeMap& map) {
  const GridRows& front = stream.rows.front();
  auto from_counts = map.from_counts;
  for (std::size_t line = 0; line < kEncoderLines; ++line)
    if (map.wheel[line] && (front.quality & quality_no_reference(static_cast<int>(line))) != 0)
      from_counts.middleRows<2>(cosine_row(*map.wheel[line])).setZero();
  for (Eigen::Index row = 0; row < run_.samples.cols(); ++row) {
    const auto& front_counts = front.counts[static_cast<std::size_t>(stream.row + row)];
    const Eigen::Matrix<double, kChannels, 1> counts =
        Eigen::Map<const Eigen::Matrix<float, kChannels, 1>>(front_counts.data()).cast<double>();
    SignalVector sum = map.at_zero_counts;
    for (const Eigen::Index c : map.used) sum += from_counts.col(c) * counts(c);
    run_.samples.col(row) += sum;
    for (const NodeMap::Reading& reading : map.readings)
      run_.readings(reading.input, row) =
          reading.at_zero_counts + reading.m_s2_per_count * counts(reading.channel);
    if (road_measured_) run_.road_m.col(row) += map.road_at_zero_counts + map.road_from_counts * counts;
  }
}

void Assembler::emit_run(const CommonRows::Run& run) {
  const auto& streams = rows_.streams();
  const GridStream& first = streams.front();
  run_.first_index = run.first_index;
  run_.restart = run.restart;
  run_.spoiled = run.spoiled;
  run_.time_ns = first.rows.front().time_ns + (first.row + run.rows - 1) * rows_.grid().period_ps / 1000;
  run_.samples.setZero(kSignals, run.rows);
  run_.readings.resize(inputs_, run.rows);
  run_.road_m.setZero(kWheels, road_measured_ ? run.rows : 0);
  for (std::size_t n = 0; n < streams.size(); ++n) add_rows(streams[n], maps_[n]);
  emit_(run_);
}

}  // namespace roadbalance
