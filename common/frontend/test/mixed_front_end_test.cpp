#include "common/frontend/mixed_front_end.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

constexpr double kRateHz = 1'000.0;

NodeTime now() {
  return as_node_time(MachineClock::now());
}

Edge edge_at(NodeTime time, std::uint8_t line = 0) {
  return {.time = time, .line = line, .kind = EdgeKind::kTooth};
}

/// Gives what a test has laid out, all at once.
class Scans final : public FrontEnd {
 public:
  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample>) noexcept override {
    Read read;
    for (; read.scans < std::min(scans.size(), due.size()); ++read.scans) scans[read.scans] = due[read.scans];
    due.erase(due.begin(), due.begin() + static_cast<std::ptrdiff_t>(read.scans));
    for (; read.edges < std::min(edges.size(), own.size()); ++read.edges) edges[read.edges] = own[read.edges];
    own.clear();
    read.status = due.empty() ? status : ReadStatus::kOk;
    return read;
  }
  bool waits() const noexcept override { return waiting; }
  NodeTime begins() const noexcept override { return node_time_from_ns(4'000'000'000); }

  void take(NodeTime time) {
    Scan scan;
    scan.index = next++;
    scan.time = time;
    due.push_back(scan);
  }
  std::vector<Scan> due;
  std::vector<Edge> own;
  std::int64_t next = 0;
  ReadStatus status = ReadStatus::kOk;
  bool waiting = false;
};

class Side final : public SideSource {
 public:
  SideRead take(std::span<Edge> room, std::span<SignalSample> samples) noexcept override {
    SideRead read{.complete_until = complete};
    read.edges = std::min(room.size(), edges.size());
    std::copy_n(edges.begin(), read.edges, room.begin());
    edges.erase(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(read.edges));
    read.signals = std::min(samples.size(), signals.size());
    std::copy_n(signals.begin(), read.signals, samples.begin());
    signals.clear();
    return read;
  }
  std::vector<const DeviceReport*> reports() const override { return {&report}; }

  std::vector<Edge> edges;
  std::vector<SignalSample> signals;
  NodeTime complete{};
  DeviceReport report{"side"};
};

struct Rig {
  Rig() {
    auto owned_scans = std::make_unique<Scans>();
    auto owned_side = std::make_unique<Side>();
    scans = owned_scans.get();
    side = owned_side.get();
    std::vector<std::unique_ptr<SideSource>> sides;
    sides.push_back(std::move(owned_side));
    mixed = std::make_unique<MixedFrontEnd>(std::move(owned_scans), std::move(sides), kRateHz);
  }
  Read read() { return mixed->read(scan, edge, signal); }
  std::int64_t counted(DeviceCounter counter) const {
    std::int64_t sum = 0;
    for (const DeviceReport* report : mixed->reports()) sum += report->of(counter);
    return sum;
  }

  Scans* scans;
  Side* side;
  std::unique_ptr<MixedFrontEnd> mixed;
  std::array<Scan, 64> scan;
  std::array<Edge, 64> edge;
  std::array<SignalSample, 64> signal;
};

constexpr auto kMillisecond = NodeClock::duration(1'000'000);

TEST(MixedFrontEnd, HoldsAScanUntilTheEdgesBeforeItHaveCome) {
  Rig rig;
  const NodeTime start = now();
  for (int k = 1; k <= 4; ++k) rig.scans->take(start + k * kMillisecond);
  rig.side->edges = {edge_at(start), edge_at(start + kMillisecond)};
  rig.side->complete = start + 2 * kMillisecond;
  Read read = rig.read();
  EXPECT_EQ(read.edges, 2U);
  ASSERT_EQ(read.scans, 2U);
  EXPECT_EQ(rig.scan[1].index, 1);

  rig.side->edges = {edge_at(start + 2 * kMillisecond + NodeClock::duration(1))};
  rig.side->complete = start + 9 * kMillisecond;
  read = rig.read();
  EXPECT_EQ(read.edges, 1U);
  EXPECT_EQ(read.scans, 2U);
  EXPECT_EQ(rig.counted(DeviceCounter::kLateEdges), 0);
}

TEST(MixedFrontEnd, MergesTheEdgesOfAllInOrderOfTime) {
  Rig rig;
  const NodeTime start = now();
  rig.scans->take(start + 9 * kMillisecond);
  rig.scans->own = {edge_at(start + 1 * kMillisecond, 1), edge_at(start + 3 * kMillisecond, 1),
                    edge_at(start + 5 * kMillisecond, 1)};
  rig.side->edges = {edge_at(start), edge_at(start + 2 * kMillisecond), edge_at(start + 4 * kMillisecond)};
  rig.side->complete = start + 20 * kMillisecond;
  const Read read = rig.read();
  ASSERT_EQ(read.edges, 6U);
  for (int k = 0; k < 6; ++k) {
    EXPECT_EQ(rig.edge[static_cast<std::size_t>(k)].time, start + k * kMillisecond);
    EXPECT_EQ(rig.edge[static_cast<std::size_t>(k)].line, k % 2);
  }
}

TEST(MixedFrontEnd, GivesScansAfterTheirEdgesWhenThereIsLittleRoom) {
  Rig rig;
  const NodeTime start = now();
  for (int k = 1; k <= 8; ++k) {
    rig.scans->take(start + k * kMillisecond);
    rig.side->edges.push_back(edge_at(start + k * kMillisecond - kMillisecond / 2));
  }
  rig.side->complete = start + 20 * kMillisecond;
  std::array<Edge, 3> few;
  const Read read = rig.mixed->read(rig.scan, few, rig.signal);
  EXPECT_EQ(read.edges, 3U);
  EXPECT_EQ(read.scans, 3U);  // the fourth scan's edge comes next
  const Read next = rig.read();
  EXPECT_EQ(next.edges, 5U);
  EXPECT_EQ(next.scans, 5U);
}

TEST(MixedFrontEnd, GoesOnWithoutASourceThatHangsAndCountsWhatComesLate) {
  Rig rig;
  const NodeTime past = now() - 200 * kMillisecond;
  rig.scans->take(past);
  rig.side->complete = past - 500 * kMillisecond;
  EXPECT_EQ(rig.read().scans, 1U);
  rig.side->edges = {edge_at(past - kMillisecond)};
  EXPECT_EQ(rig.read().edges, 0U);
  EXPECT_EQ(rig.counted(DeviceCounter::kLateEdges), 1);
}

TEST(MixedFrontEnd, MarksTheNextEdgeAfterLateOnesOfTheLine) {
  Rig rig;
  const NodeTime past = now() - 200 * kMillisecond;
  rig.scans->take(past);
  rig.side->complete = past - 500 * kMillisecond;
  EXPECT_EQ(rig.read().scans, 1U);
  Edge late_mark = edge_at(past - kMillisecond, 1);
  late_mark.kind = EdgeKind::kLost;
  rig.side->edges = {late_mark, edge_at(past, 1), edge_at(past + kMillisecond, 0),
                     edge_at(past + 2 * kMillisecond, 1), edge_at(past + 3 * kMillisecond, 1)};
  rig.scans->take(past + 9 * kMillisecond);
  const Read read = rig.read();
  ASSERT_EQ(read.edges, 4U);
  EXPECT_EQ(rig.edge[0].line, 0);
  EXPECT_EQ(rig.edge[1].line, 1);
  EXPECT_EQ(rig.edge[1].kind, EdgeKind::kLost);
  EXPECT_EQ(rig.edge[1].time, past + 2 * kMillisecond - NodeClock::duration(1));
  EXPECT_EQ(rig.edge[2].kind, EdgeKind::kTooth);
  EXPECT_EQ(rig.edge[3].kind, EdgeKind::kTooth);
  EXPECT_EQ(rig.counted(DeviceCounter::kLateEdges), 1) << "one hole";
}

TEST(MixedFrontEnd, MarksTheNextEdgeAfterThoseItHadNoRoomFor) {
  constexpr std::size_t kRoom = 16'384;
  Rig rig;
  const NodeTime start = now() + 500 * kMillisecond;  // none is late
  for (std::size_t k = 0; k < kRoom + 100; ++k)
    rig.side->edges.push_back(edge_at(start + static_cast<int>(k) * NodeClock::duration(100)));
  rig.side->complete = start - kMillisecond;
  while (!rig.side->edges.empty()) EXPECT_EQ(rig.read().edges, 0U);
  EXPECT_EQ(rig.counted(DeviceCounter::kReadersTooSlow), 1) << "one hole";
  rig.scans->take(start + 5 * kMillisecond);
  rig.scans->take(start + 50 * kMillisecond);
  rig.side->complete = start + 50 * kMillisecond;
  std::vector<Edge> given;
  const auto fetch = [&] {
    const Read read = rig.read();
    given.insert(given.end(), rig.edge.begin(), rig.edge.begin() + static_cast<std::ptrdiff_t>(read.edges));
    return read.edges;
  };
  fetch();
  rig.side->edges = {edge_at(start + 40 * kMillisecond)};
  while (fetch() > 0) {
  }
  ASSERT_EQ(given.size(), kRoom + 2);
  EXPECT_EQ(given[kRoom].kind, EdgeKind::kLost);
  EXPECT_EQ(given[kRoom + 1].kind, EdgeKind::kTooth);
  EXPECT_TRUE(std::ranges::is_sorted(given, {}, &Edge::time));
}

TEST(MixedFrontEnd, PassesSignalsOnAtOnce) {
  Rig rig;
  const NodeTime time = now();
  rig.side->signals = {{.time = time, .signal = 3, .value = 12.5}};
  rig.side->complete = time;
  const Read read = rig.read();
  ASSERT_EQ(read.signals, 1U);
  EXPECT_EQ(rig.signal[0].time, time);
  EXPECT_EQ(rig.signal[0].signal, 3);
  EXPECT_EQ(rig.signal[0].value, 12.5);
}

TEST(MixedFrontEnd, GivesAllThereIsBeforeItEnds) {
  Rig rig;
  const NodeTime future = now() + 500 * kMillisecond;
  rig.scans->take(future);
  rig.scans->status = ReadStatus::kFailed;
  rig.side->edges = {edge_at(future - kMillisecond)};
  const Read read = rig.read();
  EXPECT_EQ(read.scans, 1U);
  EXPECT_EQ(read.edges, 1U);
  EXPECT_EQ(read.status, ReadStatus::kFailed);
}

TEST(MixedFrontEnd, BeginsWhenItsScansDo) {
  EXPECT_EQ(Rig().mixed->begins(), node_time_from_ns(4'000'000'000));
}

TEST(MixedFrontEnd, RefusesADeviceThatWaitsForItsReader) {
  auto scans = std::make_unique<Scans>();
  scans->waiting = true;
  EXPECT_THROW(MixedFrontEnd(std::move(scans), {}, kRateHz), ConfigError);
}

}  // namespace
}  // namespace roadbalance
