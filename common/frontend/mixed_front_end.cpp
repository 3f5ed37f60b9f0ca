#include "common/frontend/mixed_front_end.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/config/section.hpp"

namespace roadbalance {

MixedFrontEnd::MixedFrontEnd(std::unique_ptr<FrontEnd> scans, std::vector<std::unique_ptr<SideSource>> sides,
                             double rate_hz)
    : scans_(std::move(scans)),
      sides_(std::move(sides)),
      scan_(512 + static_cast<std::size_t>(std::ceil(0.1 * rate_hz))),
      edge_(kEdgesWaiting),
      fetched_(kEdgesWaiting / 4) {
  if (scans_->waits())
    throw ConfigError(
        "devices that run by the clock cannot go with one that waits for its reader; allowed "
        "beside them: a simulation or recording with rate=1");
}

std::vector<const DeviceReport*> MixedFrontEnd::reports() const {
  std::vector<const DeviceReport*> all = scans_->reports();
  for (const auto& side : sides_)
    for (const DeviceReport* report : side->reports()) all.push_back(report);
  all.push_back(&report_);
  return all;
}

NodeTime MixedFrontEnd::from_machine(NodeTime stamp) const noexcept {
  return scans_->node_time(as_machine_time(stamp));
}

Read MixedFrontEnd::read(std::span<Scan> scans, std::span<Edge> edges,
                         std::span<SignalSample> signals) noexcept {
  Read read;
  // A side source is waited for so long at most: one that hangs does not hold up the scans.  The time is
  // taken before the sources are asked: a caller that was held up since has not waited for them.
  const NodeTime patience = scans_->node_time(MachineClock::now()) - kLongestWait;
  fetch_scans(signals, read);
  const NodeTime complete = fetch_sides(signals, read);
  const bool over = status_ != ReadStatus::kOk;
  hand_over(over ? NodeTime::max() : std::max(std::min(complete, newest_scan_), patience), scans, edges,
            read);
  if (over && scans_waiting_ == 0 && edges_waiting_ == 0) read.status = status_;
  return read;
}

void MixedFrontEnd::fetch_scans(std::span<SignalSample> signals, Read& read) noexcept {
  if (status_ != ReadStatus::kOk || scans_waiting_ == scan_.size()) return;
  const Read got = scans_->read(std::span(scan_).subspan(scans_waiting_), fetched_, signals);
  scans_waiting_ += got.scans;
  if (got.scans > 0) newest_scan_ = scan_[scans_waiting_ - 1].time;
  read.signals = got.signals;
  status_ = got.status;
  keep_edges(std::span(fetched_).first(got.edges));
}

NodeTime MixedFrontEnd::fetch_sides(std::span<SignalSample> signals, Read& read) noexcept {
  NodeTime complete = NodeTime::max();
  for (const auto& side : sides_) {
    const auto room = signals.subspan(read.signals);
    const SideRead got = side->take(fetched_, room);
    for (SignalSample& sample : room.first(got.signals)) sample.time = from_machine(sample.time);
    read.signals += got.signals;
    const auto came = std::span(fetched_).first(got.edges);
    for (Edge& edge : came) edge.time = from_machine(edge.time);
    keep_edges(came);
    complete = std::min(complete, from_machine(got.complete_until));
  }
  return complete;
}

void MixedFrontEnd::keep_edges(std::span<const Edge> edges) noexcept {
  for (const Edge& edge : edges) {
    // A mark that comes late is dropped like any edge: the mark before the next edge stands for it, too.
    const bool is_late = edge.time <= given_until_;
    if (!is_late && dropped_.pass(edge, [this](const Edge& kept) { return queue(kept); })) continue;
    if (dropped_.drop(edge.line))
      report_.count(is_late ? DeviceCounter::kLateEdges : DeviceCounter::kReadersTooSlow);
  }
}

bool MixedFrontEnd::queue(const Edge& edge) noexcept {
  if (edges_waiting_ == edge_.size()) return false;
  // Those of one source come in order, those of two nearly so: few are moved.
  auto place = edge_.begin() + static_cast<std::ptrdiff_t>(edges_waiting_++);
  for (; place != edge_.begin() && edge.time < (place - 1)->time; --place) *place = *(place - 1);
  *place = edge;
  return true;
}

void MixedFrontEnd::hand_over(NodeTime until, std::span<Scan> scans, std::span<Edge> edges,
                              Read& read) noexcept {
  const auto edges_end = edge_.begin() + static_cast<std::ptrdiff_t>(edges_waiting_);
  const auto ready = std::upper_bound(edge_.begin(), edges_end, until,
                                      [](NodeTime time, const Edge& edge) { return time < edge.time; });
  read.edges = std::min(static_cast<std::size_t>(ready - edge_.begin()), edges.size());
  const auto edges_given = edge_.begin() + static_cast<std::ptrdiff_t>(read.edges);
  std::copy(edge_.begin(), edges_given, edges.begin());
  if (edges_given != ready) until = std::min(until, edges_given->time);  // scans after it wait for it
  std::copy(edges_given, edges_end, edge_.begin());
  edges_waiting_ -= read.edges;

  while (read.scans < std::min(scans.size(), scans_waiting_) && scan_[read.scans].time <= until) ++read.scans;
  const auto scans_given = scan_.begin() + static_cast<std::ptrdiff_t>(read.scans);
  std::copy(scan_.begin(), scans_given, scans.begin());
  std::copy(scans_given, scan_.begin() + static_cast<std::ptrdiff_t>(scans_waiting_), scan_.begin());
  scans_waiting_ -= read.scans;
  if (read.edges > 0) given_until_ = std::max(given_until_, edges[read.edges - 1].time);
  if (read.scans > 0) given_until_ = std::max(given_until_, scans[read.scans - 1].time);
}

}  // namespace roadbalance
