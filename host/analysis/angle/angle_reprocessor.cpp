#include "host/analysis/angle/angle_reprocessor.hpp"

#include <algorithm>
#include <cmath>

#include "common/angle/wanted_signal.hpp"
#include "common/bus/alarm.hpp"
#include "common/bus/codec.hpp"
#include "common/types/angle_sigma.hpp"

namespace roadbalance {
namespace {

constexpr std::array kUncertain{kQualityUncertainAngle0, kQualityUncertainAngle1};

}  // namespace

AngleReprocessor::AngleReprocessor(const VehicleConfig& vehicle, WithoutMark without_mark, Teeth teeth)
    : vehicle_(vehicle), without_mark_(without_mark) {
  for (const WheelConfig& wheel : vehicle_.wheel) {
    if (wheel.node.empty()) continue;
    const NodeConfig& node = vehicle_.node_named(wheel.node);
    const bool turned = !wheel.encoder.zero_mark && without_mark == WithoutMark::kTurned;
    const auto speed = speed_signal(node.wiring, wheel.name);
    if (const auto counter = counter_signal(node.wiring, wheel.encoder.counter))
      add(wheel, node, *counter, false);
    else if (turned ? wheel.encoder.pulses_per_turn > 0 : teeth == Teeth::kAgain && wheel.encoder.zero_mark)
      add(wheel, node, std::nullopt, false);
    else if (turned && speed)
      add(wheel, node, *speed, true);
  }
}

void AngleReprocessor::add(const WheelConfig& wheel, const NodeConfig& node, std::optional<int> signal_number,
                           bool by_speed) {
  Wheel& added = wheel_.emplace_back();
  added.config = &wheel;
  added.node = node.id;
  added.signal = signal_number ? node.wiring.signal(*signal_number) : nullptr;
  added.signal_number = signal_number;
  added.by_speed = by_speed;
  if (!node_.contains(node.id))
    node_.emplace(node.id, Node{.filter = ReferenceFilter(vehicle_.filter, node.rate_hz),
                                .steering_signal = steering_signal(node.wiring),
                                .steering = {},
                                .track = {},
                                .angle_rad = {}});
}

void AngleReprocessor::learn(const SealedBlock& block) {
  const auto node = node_.find(block.header.node);
  if (node == node_.end()) return;
  const std::int64_t epoch = block.header.epoch;
  if (block.kind == BlockKind::kSignal) {
    for (const SignalSample& sample : decode_signal(block).unpack()) {
      if (sample.signal == node->second.steering_signal) node->second.steering[epoch].push_back(sample);
      for (Wheel& wheel : wheel_)
        if (wheel.node == block.header.node && sample.signal == wheel.signal_number)
          wheel.epoch[epoch].samples.push_back(sample);
    }
  } else if (block.kind == BlockKind::kEdge) {
    for (const Edge& edge : decode_edge(block).unpack())
      for (Wheel& wheel : wheel_)
        if (wheel.node == block.header.node && edge.line == wheel.config->line &&
            (!wheel.signal || edge.kind == EdgeKind::kZeroMark)) {
          memory_.add(1);
          wheel.epoch[epoch].edges.push_back(edge);
        }
  }
}

const AngleReprocessor::Epoch& AngleReprocessor::made(Wheel& wheel, std::int64_t epoch) {
  Epoch& data = wheel.epoch[epoch];
  if (data.counter || data.speed || data.teeth) return data;
  if (wheel.by_speed)
    data.speed = std::make_unique<RecordedSpeed>(data.samples, wheel.config->rolling_radius_m);
  else if (wheel.signal)
    data.counter =
        std::make_unique<RecordedCounter>(wheel.config->encoder, *wheel.signal, data.samples, data.edges);
  else
    data.teeth = std::make_unique<RecordedAngle>(wheel.config->encoder, data.edges);
  data.samples = {};
  data.edges = {};
  return data;
}

/// Whether any epoch has a mark to count from.
bool AngleReprocessor::located(Wheel& wheel) {
  if (wheel.located) return *wheel.located;
  wheel.located = false;
  for (auto& [number, data] : wheel.epoch) {
    const Epoch& epoch = made(wheel, number);
    const bool marked =
        (epoch.counter && epoch.counter->common_sigma_rad()) ||
        (epoch.teeth && wheel.config->encoder.zero_mark && !epoch.teeth->teeth().runs.empty());
    wheel.located = *wheel.located || marked;
  }
  return *wheel.located;
}

/// Angles if they are known, else how far the wheel has turned if that is wanted.
bool AngleReprocessor::turned(Wheel& wheel, const ScanBlock& block, NodeTime from, double step_ns,
                              std::span<double> angle_rad) {
  const Epoch& epoch = made(wheel, block.header.epoch);
  if (epoch.speed) return epoch.speed->turned(from, step_ns, angle_rad);
  if (epoch.teeth) {
    if (!located(wheel)) return epoch.teeth->turned(from, step_ns, angle_rad);
    if (!epoch.teeth->angles(from, step_ns, angle_rad)) return false;
    count(wheel, epoch.teeth->sigma_rad(), block);
    return true;
  }
  RecordedCounter& counter = *epoch.counter;
  if (without_mark_ == WithoutMark::kTurned && !located(wheel))
    return counter.turned(from, step_ns, angle_rad);
  if (!counter.angles(from, step_ns, angle_rad)) return false;
  count(wheel, counter.sigma_rad(), block);
  return true;
}

void AngleReprocessor::count(Wheel& wheel, double sigma_rad, const ScanBlock& block) {
  wheel.square += sigma_rad * sigma_rad * static_cast<double>(block.header.scans);
  wheel.rows += block.header.scans;
  wheel.told_sigma_rad = sigma_rad;
}

/// Angles at all of the filter's steps; false if they are not known.
bool AngleReprocessor::look_up(Wheel& wheel, Node& node, const ScanBlock& block,
                               std::vector<double>& angle_rad, bool& uncertain) {
  wheel.told_sigma_rad = -1.0;
  angle_rad.resize(static_cast<std::size_t>(node.filter.steps(static_cast<int>(block.header.scans))));
  const NodeTime from = node.filter.first_step(node_time_from_ns(block.header.time_ns));
  const double step_ns = node.filter.step_ns();
  if (!turned(wheel, block, from, step_ns, angle_rad)) return false;
  if (const auto& teeth = wheel.epoch[block.header.epoch].teeth) {
    const auto last_row_ns = block.row_time_ns(block.header.scans - 1);
    uncertain = teeth->uncertain(node_time_from_ns(block.header.time_ns), node_time_from_ns(last_row_ns));
  }
  const double ratio = wheel.config->encoder.steering_ratio;
  if (ratio == 0.0) return true;
  const auto& samples = node.steering[block.header.epoch];
  auto track = node.track.find(block.header.epoch);
  if (track == node.track.end()) {
    track = node.track.emplace(block.header.epoch, SteeringTrack(samples.size() + 2)).first;
    for (const SignalSample& sample : samples) track->second.add(to_ns(sample.time), sample.value);
  }
  if (!track->second.take_out(ratio, to_ns(from), step_ns, angle_rad)) uncertain = true;
  return true;
}

void AngleReprocessor::replace(ScanBlock& block, Node& node) {
  const BlockHeader& header = block.header;
  const bool after_jump = header.epoch != node.epoch || header.first_scan != node.next_scan;
  node.epoch = header.epoch;
  node.next_scan = header.first_scan + header.scans;
  ReferenceFilter::Angles known{};
  std::array<bool, kEncoderLines> here{}, uncertain{};
  std::array<double, kEncoderLines> sigma_rad{};
  for (Wheel& wheel : wheel_) {
    if (wheel.node != header.node) continue;
    const auto line = static_cast<std::size_t>(wheel.config->line);
    here[line] = true;
    if (look_up(wheel, node, block, node.angle_rad[line], uncertain[line]))
      known[line] = node.angle_rad[line];
    sigma_rad[line] = known[line].empty() ? -1.0 : wheel.told_sigma_rad;
  }
  auto filled = block.counts;
  const auto rows = std::span(filled).first(static_cast<std::size_t>(header.scans));
  const std::int32_t quality = node.filter.fill(rows, known, after_jump);
  for (std::size_t line = 0; line < kEncoderLines; ++line) {
    if (!here[line]) continue;
    const std::int32_t unknown = quality_no_reference(static_cast<int>(line));
    block.quality &= ~(unknown | kUncertain[line]);
    block.quality |= (quality & unknown) | (uncertain[line] ? kUncertain[line] : 0);
    block.quality = with_angle_sigma(block.quality, static_cast<int>(line), sigma_rad[line]);
    for (std::size_t row = 0; row < rows.size(); ++row)
      std::copy_n(rows[row].begin() + static_cast<std::ptrdiff_t>(kAccelerations + 2 * line), 2,
                  block.counts[row].begin() + static_cast<std::ptrdiff_t>(kAccelerations + 2 * line));
  }
}

const SealedBlock& AngleReprocessor::reprocess(const SealedBlock& block) {
  const auto node = node_.find(block.header.node);
  if (block.kind != BlockKind::kScan || node == node_.end()) return block;
  ScanBlock scans = decode_scan(block);
  replace(scans, node->second);
  seal(scans, out_);
  return out_;
}

std::optional<AngleReprocessor::Quality> AngleReprocessor::quality(int wheel) {
  const WheelConfig* const config = &vehicle_.wheel[static_cast<std::size_t>(wheel)];
  const auto found = std::ranges::find(wheel_, config, &Wheel::config);
  if (found == wheel_.end()) return std::nullopt;
  Quality quality{.located = located(*found),
                  .by_speed = found->by_speed,
                  .pulses_per_turn = config->encoder.pulses_per_turn};
  double common = 0.0, epochs = 0.0;
  for (const auto& [number, epoch] : found->epoch) {
    std::optional<double> sigma;
    if (epoch.teeth) {
      const NumberedTeeth& teeth = epoch.teeth->teeth();
      quality.marks_dropped += teeth.marks_dropped;
      if (teeth.mark_counts[0] > 0) quality.mark_counts = teeth.mark_counts;
      for (const NumberedRun& run : teeth.runs)
        quality.marks += static_cast<std::int64_t>(run.marks_ns.size());
      if (quality.located && !teeth.runs.empty()) sigma = epoch.teeth->common_sigma_rad();
    }
    if (epoch.counter) {
      quality.marks += epoch.counter->marks();
      quality.marks_dropped += epoch.counter->marks_dropped();
      sigma = epoch.counter->common_sigma_rad();
    }
    if (!sigma) continue;
    common += *sigma * *sigma;
    epochs += 1.0;
  }
  quality.sigma_rad = std::sqrt(found->square / static_cast<double>(std::max<std::int64_t>(found->rows, 1)));
  quality.common_sigma_rad = std::sqrt(common / std::max(epochs, 1.0));
  return quality;
}

std::string AngleReprocessor::Quality::contradiction() const {
  if (mark_counts[0] > 0) return wrong_marks(mark_counts, pulses_per_turn);
  if (located || marks_dropped == 0) return {};
  return "of its " + std::to_string(marks + marks_dropped) + " zero marks " + std::to_string(marks_dropped) +
         " lie elsewhere than the rest, so that none counts: is pulses_per_turn right?";
}

}  // namespace roadbalance
