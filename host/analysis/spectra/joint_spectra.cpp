#include "host/analysis/spectra/joint_spectra.hpp"

#include <algorithm>
#include <utility>

#include "host/analysis/identify/assemble.hpp"

namespace roadbalance {
JointSpectra::JointSpectra(const VehicleConfig& vehicle, std::vector<ChannelPlace> channels,
                           const Settings& settings)
    : rows_(Assembler::kLongestWait_s),
      spectra_({.welch = {.rate_hz = vehicle.node.front().rate_hz,
                          .segment = settings.segment,
                          .overlap = settings.overlap,
                          .window = settings.window},
                .channels = static_cast<int>(channels.size()),
                .memory = settings.memory,
                .hold_peaks = settings.hold_peaks}) {
  std::vector<int> nodes;
  for (const ChannelPlace& place : channels)
    if (std::find(nodes.begin(), nodes.end(), place.node) == nodes.end()) nodes.push_back(place.node);
  for (const int n : nodes) {
    std::int32_t unusable = 0;
    for (const ChannelPlace& place : channels)
      if (place.node == n) unusable |= 1 << place.channel;
    rows_.add(vehicle.node[static_cast<std::size_t>(n)], nodes.size() == 1, unusable);
  }
  for (const ChannelPlace& place : channels) {
    const ChannelConfig& channel = vehicle.node[static_cast<std::size_t>(place.node)].channel.at(
        static_cast<std::size_t>(place.channel));
    const auto stream = std::find(nodes.begin(), nodes.end(), place.node) - nodes.begin();
    sources_.push_back({static_cast<std::size_t>(stream), static_cast<std::size_t>(place.channel),
                        channel.scale_m_s2_per_count, channel.to_si(0.0)});
  }
}

void JointSpectra::consume(const SealedBlock& block) {
  if (rows_.take(block)) take_runs();
}

void JointSpectra::consume(const ClockFit& fit) {
  if (rows_.take(fit)) take_runs();
}

void JointSpectra::take_runs() {
  while (const auto run = rows_.next()) {
    if (run->restart) {
      spectra_.gap();
      ++runs_;
    }
    samples_.resize(static_cast<Eigen::Index>(sources_.size()), run->rows);
    for (std::size_t s = 0; s < sources_.size(); ++s) {
      const Source& source = sources_[s];
      const GridStream& stream = rows_.streams()[source.stream];
      for (Eigen::Index row = 0; row < run->rows; ++row) {
        const auto& counts = stream.rows.front().counts[static_cast<std::size_t>(stream.row + row)];
        samples_(static_cast<Eigen::Index>(s), row) =
            source.offset + source.scale * static_cast<double>(counts[source.channel]);
      }
    }
    spectra_.add(samples_);
    const GridRows& front = rows_.streams().front().rows.front();
    end_ns_ = front.time_ns + (rows_.streams().front().row + run->rows - 1) * rows_.grid().period_ps / 1000;
    rows_.use(*run);
  }
  rows_.drop_what_nobody_meets();
}

}  // namespace roadbalance
