#include "hil_tests/players/drive_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "common/bus/codec.hpp"
#include "firmware/backends/replay/front_end.hpp"
#include "host/recording/read_recording.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance::test {
namespace {

/// Things of one kind, in order of time.
template <typename Key, typename Item, typename KeyOf>
std::map<Key, std::vector<Item>> by_kind(const std::vector<Item>& items, KeyOf key_of) {
  std::map<Key, std::vector<Item>> kinds;
  for (const Item& item : items) kinds[key_of(item)].push_back(item);
  return kinds;
}

std::int64_t difference(std::size_t a, std::size_t b) {
  return std::abs(static_cast<std::int64_t>(a) - static_cast<std::int64_t>(b));
}

void compare_scans(const NodeDrive& truth, const NodeDrive& seen, const Timetable& timetable,
                   DriveDifference& result) {
  // The conversion nearest to the first scan's instant is its own.
  const NodeTime begin = as_node_time(timetable.at(truth.first_scan()));
  const auto half_period = (truth.scans[1].time - truth.scans[0].time) / 2;
  const auto first = static_cast<std::size_t>(
      std::ranges::lower_bound(seen.scans, begin - half_period, {}, &Scan::time) - seen.scans.begin());
  for (std::size_t k = 0; k < truth.scans.size(); ++k) {
    if (first + k >= seen.scans.size() || seen.scans[first + k].counts != truth.scans[k].counts) {
      ++result.scans;
      continue;
    }
    result.scan.add(seen.scans[first + k].time - as_node_time(timetable.at(truth.scans[k].time)));
  }
}

void compare_edges(const NodeDrive& truth, const NodeDrive& seen, const Timetable& timetable,
                   DriveDifference& result) {
  const auto key = [](const Edge& edge) { return std::pair(edge.line, edge.kind); };
  const auto expected = by_kind<std::pair<std::uint8_t, EdgeKind>>(truth.edges, key);
  auto found = by_kind<std::pair<std::uint8_t, EdgeKind>>(seen.edges, key);
  for (const auto& [kind, edges] : expected) {
    const auto its = std::move(found[kind]);
    found.erase(kind);
    result.edges += difference(edges.size(), its.size());
    for (std::size_t k = 0; k < std::min(edges.size(), its.size()); ++k)
      result.edge.add(its[k].time - as_node_time(timetable.at(edges[k].time)));
  }
  for (const auto& [kind, edges] : found) result.edges += static_cast<std::int64_t>(edges.size());
}

void compare_samples(const NodeDrive& truth, const NodeDrive& seen, const Timetable& timetable,
                     double half_step, DriveDifference& result) {
  const auto key = [](const SignalSample& sample) { return sample.signal; };
  const auto expected = by_kind<std::uint16_t>(truth.signals, key);
  auto found = by_kind<std::uint16_t>(seen.signals, key);
  for (const auto& [signal, samples] : expected) {
    const auto its = std::move(found[signal]);
    found.erase(signal);
    result.samples += difference(samples.size(), its.size());
    for (std::size_t k = 0; k < std::min(samples.size(), its.size()); ++k) {
      if (!(std::abs(its[k].value - samples[k].value) <= half_step)) ++result.samples;
      result.sample.add(its[k].time - as_node_time(timetable.at(samples[k].time)));
    }
  }
  for (const auto& [signal, samples] : found) result.samples += static_cast<std::int64_t>(samples.size());
}

}  // namespace

void StampError::add(NodeClock::duration late) {
  const double late_s = to_seconds(late);
  least_s_ = count_ == 0 ? late_s : std::min(least_s_, late_s);
  most_s_ = count_ == 0 ? late_s : std::max(most_s_, late_s);
  ++count_;
  sum_s_ += late_s;
  sum_of_squares_s2_ += late_s * late_s;
}

double StampError::rms_about_mean_s() const {
  if (count_ == 0) return 0.0;
  return std::sqrt(std::max(0.0, sum_of_squares_s2_ / static_cast<double>(count_) - mean_s() * mean_s()));
}

double StampError::spread_s() const {
  return std::max(most_s_ - mean_s(), mean_s() - least_s_);
}

std::string StampError::text() const {
  char text[120];
  std::snprintf(text, sizeof text, "%lld stamps late by %.2f us, +- %.2f us, %.2f to %.2f us",
                static_cast<long long>(count_), 1e6 * mean_s(), 1e6 * rms_about_mean_s(), 1e6 * least_s_,
                1e6 * most_s_);
  return text;
}

double DriveDifference::angle_time_spread_s() const {
  return edge.spread_s() + scan.spread_s();
}

DriveDifference compare(const NodeDrive& truth, const NodeDrive& seen, const Timetable& timetable,
                        double half_step) {
  DriveDifference result;
  compare_scans(truth, seen, timetable, result);
  compare_edges(truth, seen, timetable, result);
  compare_samples(truth, seen, timetable, half_step, result);
  return result;
}

NodeDrive recorded_drive(const std::filesystem::path& folder, const VehicleConfig& vehicle,
                         const NodeConfig& node) {
  return read_drive(*open_replay_front_end({folder.string() + "?rate=max", vehicle, node}), node.name,
                    node.rate_hz);
}

namespace {

/// The block without the scans before an instant, half a scan less; nothing if it has no others.
std::optional<SealedBlock> cut_before(NodeTime from, const SealedBlock& block) {
  ScanBlock rest = decode_scan(block);
  std::int64_t early = 0;
  while (early < rest.header.scans && rest.row_time_ns(early) + rest.period_ps / 2000 < to_ns(from)) ++early;
  if (early == rest.header.scans) return std::nullopt;
  if (early == 0) return block;
  std::ranges::rotate(rest.counts, rest.counts.begin() + early);
  rest.header.time_ns = rest.row_time_ns(early);
  rest.header.first_scan += early;
  rest.header.scans -= early;
  SealedBlock cut;
  seal(rest, cut);
  return cut;
}

}  // namespace

// Nodes whose clocks were not asked for have the time of all.  Given as a fit, it makes the estimator bring
// their samples to the grid from the first one on, as it does those of nodes with clocks of their own; else
// it begins, and cuts the sections, where a converter has left the grid.
DriveEstimate identify_from(const std::filesystem::path& folder, NodeTime from) {
  std::optional<DriveEstimator> estimator;
  std::set<std::pair<std::int32_t, std::int64_t>> fitted;
  read_recording(
      folder, [&](const VehicleConfig& vehicle) { estimator.emplace(vehicle); },
      [&](const SealedBlock& block) {
        if (block.kind != BlockKind::kScan) return;
        const auto wanted = cut_before(from, block);
        if (!wanted) return;
        if (fitted.insert({block.header.node, block.header.epoch}).second)
          estimator->consume(
              ClockFit{.node = block.header.node, .epoch = block.header.epoch, .state = ClockState::kLocked});
        estimator->consume(*wanted);
      },
      [&](const ClockFit& fit) {
        fitted.insert({fit.node, fit.epoch});
        estimator->consume(fit);
      });
  return estimator->estimate();
}

std::vector<std::string> device_troubles(const std::filesystem::path& folder) {
  std::vector<std::string> troubles;
  for (const std::string& note : verify_record(folder).notes)
    for (std::size_t k = 0; k < kDeviceCounters; ++k)
      if (note.find(sentence(static_cast<DeviceCounter>(k))) != std::string::npos) {
        troubles.push_back(note);
        break;
      }
  return troubles;
}

}  // namespace roadbalance::test
