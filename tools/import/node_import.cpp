#include "tools/import/node_import.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/bus/alarm.hpp"
#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/text/format.hpp"
#include "common/vehicle/gravity.hpp"
#include "host/analysis/identify/clipped_channels.hpp"

namespace roadbalance {
namespace {

// As many as a node takes from its device at once.
constexpr std::size_t kScansAtOnce = 64, kEdgesAtOnce = 4096;

constexpr double kMostOffset_m_s2 =
    2.0 * kStandardGravity_m_s2;             // gravity is 1 g, no road gives a second's mean of another
constexpr double kLeastSpread_counts = 0.5;  // less is not even quantisation noise

constexpr double kLimit_counts = kFullScaleCounts - 1;

std::int32_t counts_of(const ChannelConfig& channel, double value_m_s2) {
  const double counts = value_m_s2 / channel.scale_m_s2_per_count + channel.offset_counts;
  return static_cast<std::int32_t>(std::lround(std::clamp(counts, -kLimit_counts, kLimit_counts)));
}

}  // namespace

ChannelSuspicion::ChannelSuspicion(const ChannelConfig& channel, double rate_hz)
    : channel_(channel),
      samples_a_second_(std::max<std::int64_t>(1, std::llround(rate_hz))),
      clipping_(rate_hz) {}

void ChannelSuspicion::add(double value_m_s2) {
  if (std::abs(value_m_s2) >= kRangeEnd * channel_.range_m_s2) ++clipped_;
  if (std::isnan(value_m_s2))
    clipping_.skip();
  else
    clipping_.add(counts_of(channel_, value_m_s2));
  ++samples_;
  const double off = value_m_s2 - mean_;
  mean_ += off / static_cast<double>(samples_);
  squares_ += off * (value_m_s2 - mean_);
  if (samples_ == samples_a_second_) end_second();
}

void ChannelSuspicion::end_second() {
  ++seconds_;
  if (std::sqrt(squares_ / static_cast<double>(samples_)) <
      kLeastSpread_counts * channel_.scale_m_s2_per_count)
    ++constant_;
  if (std::abs(mean_) > kMostOffset_m_s2) {
    ++offset_;
    sum_offset_ += mean_;
  }
  samples_ = 0;
  mean_ = squares_ = 0.0;
}

std::vector<std::string> ChannelSuspicion::found() const {
  std::vector<std::string> found;
  const std::string of_seconds = " of " + std::to_string(seconds_) + " s";
  if (offset_ > 0) {
    const double mean_g = sum_offset_ / static_cast<double>(offset_) / kStandardGravity_m_s2;
    found.push_back("sits at " + format("%.1f", mean_g) + " g on average during " + std::to_string(offset_) +
                    of_seconds + ": more than gravity");
  }
  if (constant_ > 0) found.push_back("is constant during " + std::to_string(constant_) + of_seconds);
  if (auto clause = clipped_clause(channel_, clipping_.limits())) found.push_back(*std::move(clause));
  if (clipped_ > 0) found.push_back("reaches its full scale in " + std::to_string(clipped_) + " samples");
  return found;
}

NodeImport::NodeImport(const VehicleConfig& vehicle, const NodeConfig& node, const ColumnOf& columns,
                       std::int64_t epoch, const std::filesystem::path& samples, EpochPacker::Take take)
    : vehicle_(vehicle),
      node_(node),
      samples_(samples),
      packer_(
          vehicle, node, epoch,
          [this, take = std::move(take)](const SealedBlock& block) {
            ++counts_.blocks;
            if (block.kind == BlockKind::kScan) counts_.scans += block.header.scans;
            if (block.kind == BlockKind::kGap) counts_.scans_missing += block.header.scans;
            if (block.kind == BlockKind::kEdge) counts_.edges += decode_edge(block).edges;
            take(block);
          },
          GapCause::kSourceGap) {
  for (std::size_t k = 0; k < node.channel.size(); ++k) {
    const auto found = columns.find(node.channel[k].name);
    if (found == columns.end()) continue;  // unused, its counts stay 0
    input_.push_back({k, found->second});
    if (node.channel[k].role == ChannelRole::kAcceleration)
      suspicion_.emplace_back(input_.back(), ChannelSuspicion(node.channel[k], node.rate_hz));
  }
}

void NodeImport::add(const Edge& edge) {
  edges_.push_back(edge);
  if (edges_.size() == kEdgesAtOnce) seal();
}

bool NodeImport::is_there(std::span<const double> cells, std::int64_t row) const {
  const auto is_empty = [&](const Input& input) { return std::isnan(cells[input.column]); };
  const auto empty = std::ranges::count_if(input_, is_empty);
  if (empty == 0 || empty == std::ssize(input_)) return empty == 0;
  throw ConfigError(samples_.string() + ": sample " + std::to_string(row + 1) + ": " +
                    node_.channel[std::ranges::find_if(input_, is_empty)->channel].name +
                    ": is empty; allowed: a number, or all channels of node " + node_.name +
                    " empty where it has no sample");
}

void NodeImport::add(std::span<const double> cells, std::int64_t row, std::int64_t index, NodeTime time) {
  for (auto& [input, suspicion] : suspicion_) suspicion.add(cells[input.column]);
  if (row == 0) packer_.begin_at(index, time);
  end_index_ = index + 1;
  end_time_ = time + NodeClock::duration(std::llround(1e9 / node_.rate_hz));
  if (!is_there(cells, row)) return;
  has_sample_ = true;
  Scan& scan = scans_.emplace_back(Scan{.index = index, .time = time});
  for (const Input& input : input_) {
    const ChannelConfig& channel = node_.channel[input.channel];
    const double value = cells[input.column];
    scan.counts[input.channel] = counts_of(channel, value);
    if (std::abs(value) >= kRangeEnd * channel.range_m_s2 ||
        std::abs(value / channel.scale_m_s2_per_count + channel.offset_counts) > kLimit_counts)
      scan.overload |= 1U << input.channel;
  }
  if (scans_.size() == kScansAtOnce) seal();
}

void NodeImport::seal() {
  packer_.add(scans_, edges_);
  scans_.clear();
  edges_.clear();
  for (int line = 0; line < kEncoderLines; ++line)
    if (const auto counts = packer_.mark_counts(line); counts[0] > 0)
      mark_counts_[static_cast<std::size_t>(line)] = counts;
}

// Its epoch would be one gap, from which nothing can be computed.
void NodeImport::refuse_absence() const {
  std::string channels;
  for (const Input& input : input_)
    channels += (channels.empty() ? "" : ", ") + node_.channel[input.channel].name;
  throw ConfigError(samples_.string() + ": node " + node_.name + " has no sample: each of " + channels +
                    " is empty, not available or out of its range; allowed: samples of each node, or a file "
                    "and a vehicle's description without the node");
}

void NodeImport::end() {
  if (!has_sample_) refuse_absence();
  seal();
  packer_.end_at(end_index_, end_time_);
  packer_.end();
}

std::vector<std::pair<std::string, std::string>> NodeImport::suspicions() const {
  std::vector<std::pair<std::string, std::string>> all;
  for (const auto& [input, suspicion] : suspicion_)
    for (std::string& what : suspicion.found())
      all.emplace_back(node_.channel[input.channel].name, std::move(what));
  for (int line = 0; line < kEncoderLines; ++line) {
    const auto& counts = mark_counts_[static_cast<std::size_t>(line)];
    const WheelConfig* const wheel = vehicle_.wheel_at(node_, line);
    if (wheel && counts[0] > 0)
      all.emplace_back(wheel->name, "has no angle: " + wrong_marks(counts, wheel->encoder.pulses_per_turn));
  }
  return all;
}

}  // namespace roadbalance
