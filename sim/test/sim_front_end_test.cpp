#include "sim/front_end.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "common/config/section.hpp"
#include "common/test/no_allocation.hpp"
#include "sim/test/test_car.hpp"

namespace roadbalance::sim {
namespace {

struct Data {
  std::vector<Scan> scans;
  std::vector<Edge> edges;
};

std::unique_ptr<FrontEnd> open(const std::string& address, const std::string& node = "front") {
  static const VehicleConfig vehicle = test::reference_vehicle();
  return open_sim_front_end({address, vehicle, vehicle.node[node == "front" ? 0 : 1]});
}

/// Reads until `scans` are there or the device ends.
Data read(FrontEnd& device, std::size_t scans, std::size_t scan_room = 100, std::size_t edge_room = 256) {
  Data data;
  std::vector<Scan> some_scans(scan_room);
  std::vector<Edge> some_edges(edge_room);
  while (data.scans.size() < scans) {
    const std::size_t room = std::min(scan_room, scans - data.scans.size());
    const Read read = device.read(std::span(some_scans).first(room), some_edges, {});
    data.scans.insert(data.scans.end(), some_scans.begin(),
                      some_scans.begin() + static_cast<std::ptrdiff_t>(read.scans));
    data.edges.insert(data.edges.end(), some_edges.begin(),
                      some_edges.begin() + static_cast<std::ptrdiff_t>(read.edges));
    if (read.status != ReadStatus::kOk) break;
  }
  return data;
}

void expect_same_edge(const Edge& a, const Edge& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.line, b.line);
  EXPECT_EQ(a.kind, b.kind);
}

/// `late` must be the tail of `whole`, with scan indices of its own.
void expect_tail(const Data& whole, const Data& late) {
  ASSERT_FALSE(late.scans.empty());
  const auto skipped = std::llround(to_seconds(late.scans[0].time.time_since_epoch()) * 2000.0);
  ASSERT_LE(static_cast<std::size_t>(skipped) + late.scans.size(), whole.scans.size());
  for (std::size_t k = 0; k < late.scans.size(); ++k) {
    const Scan& expected = whole.scans[k + static_cast<std::size_t>(skipped)];
    ASSERT_EQ(late.scans[k].index, static_cast<std::int64_t>(k));
    ASSERT_EQ(late.scans[k].time, expected.time);
    ASSERT_EQ(late.scans[k].counts, expected.counts);
    ASSERT_EQ(late.scans[k].overload, expected.overload);
  }
  ASSERT_FALSE(late.edges.empty());
  const NodeTime before = whole.scans[static_cast<std::size_t>(skipped) - 1].time;
  std::size_t i = 0;
  while (whole.edges[i].time <= before) ++i;
  for (const Edge& edge : late.edges) expect_same_edge(edge, whole.edges[i++]);
}

TEST(SimFrontEnd, DeliversTheWholeDriveAndEnds) {
  const auto device = open("?rate=max&seconds=2&seed=3");
  EXPECT_TRUE(device->waits());
  const Data data = read(*device, 1'000'000);
  ASSERT_EQ(data.scans.size(), 4000U);
  for (std::size_t k = 0; k < data.scans.size(); ++k) {
    EXPECT_EQ(data.scans[k].index, static_cast<std::int64_t>(k));
    EXPECT_EQ(to_ns(data.scans[k].time), static_cast<std::int64_t>(k) * 500'000);
  }
  std::vector<Scan> scan(1);
  std::vector<Edge> edge(64);
  const Read after = device->read(scan, edge, {});
  EXPECT_EQ(after.scans, 0U);
  EXPECT_EQ(after.status, ReadStatus::kEnd);
}

TEST(SimFrontEnd, EdgesComeInOrderAndCompleteBeforeTheirScanWhateverRoomTheReaderGives) {
  const Data reference = read(*open("?rate=max&seconds=1.5"), 3000);
  for (const std::size_t edge_room : {1U, 3U, 64U}) {
    const auto device = open("?rate=max&seconds=1.5");
    Data data;
    std::vector<Scan> scans(7);
    std::vector<Edge> edges(edge_room);
    for (;;) {
      const Read read = device->read(scans, edges, {});
      for (std::size_t i = 0; i < read.edges; ++i) data.edges.push_back(edges[i]);
      for (std::size_t i = 0; i < read.scans; ++i) data.scans.push_back(scans[i]);
      // Whatever is stamped up to the last scan must have come: then the next edge of the reference is later.
      if (!data.scans.empty() && data.edges.size() < reference.edges.size()) {
        ASSERT_GT(reference.edges[data.edges.size()].time, data.scans.back().time);
      }
      if (read.status == ReadStatus::kEnd) break;
    }
    ASSERT_EQ(data.scans.size(), reference.scans.size());
    ASSERT_EQ(data.edges.size(), reference.edges.size());
    for (std::size_t i = 0; i < data.edges.size(); ++i) expect_same_edge(data.edges[i], reference.edges[i]);
  }
  for (std::size_t i = 1; i < reference.edges.size(); ++i)
    ASSERT_LE(reference.edges[i - 1].time, reference.edges[i].time);
}

TEST(SimFrontEnd, ARestartedNodeSeesTheSameCarBitForBit) {
  const Data whole = read(*open("?rate=max&seconds=4&seed=5"), 8000);
  const Data late = read(*open("?rate=max&seconds=4&seed=5&from=2.34567"), 8000);
  EXPECT_EQ(late.scans.size(), 8000U - 4692U);  // 2.34567 s are 4691.34 scans
  expect_tail(whole, late);
}

TEST(SimFrontEnd, ANodeOpenedLateJoinsAtThePresentBusTime) {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  const auto start = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count() - 50'000'000;
  const auto device = open("?rate=20&seconds=600&seed=5&start_ns=" + std::to_string(start));
  EXPECT_TRUE(device->waits());
  const Data late = read(*device, 500);
  ASSERT_GE(late.scans[0].time, node_time_from_ns(1'000'000'000));  // 20 times 50 ms, and a bit
  const auto last = std::llround(to_seconds(late.scans.back().time.time_since_epoch()) * 2000.0);
  expect_tail(read(*open("?rate=max&seconds=600&seed=5"), static_cast<std::size_t>(last) + 1), late);
}

TEST(SimFrontEnd, WaitsForItsReaderAtAnyRateButOne) {
  EXPECT_FALSE(open("?rate=1")->waits());
  EXPECT_FALSE(open("")->waits());
  EXPECT_TRUE(open("?rate=20")->waits());
  EXPECT_TRUE(open("?rate=0.5")->waits());
  EXPECT_TRUE(open("?rate=max")->waits());
}

TEST(SimFrontEnd, AFastConverterTakesMoreScansOfTheSameDrive) {
  const Data nominal = read(*open("?rate=max&seconds=20"), 1'000'000);
  const Data fast = read(*open("?rate=max&seconds=20&converter_ppm=500"), 1'000'000);
  ASSERT_EQ(nominal.scans.size(), 40'000U);
  ASSERT_EQ(fast.scans.size(), 40'020U);
  for (std::size_t k = 0; k < fast.scans.size(); ++k)
    ASSERT_NEAR(static_cast<double>(to_ns(fast.scans[k].time)), static_cast<double>(k) * 5e5 / 1.0005, 0.51);
  // The wheels do not depend on converters.  Between instants of scans positions are cubic in time, to 1 ns.
  for (std::size_t i = 0; i < 5000; ++i)
    ASSERT_NEAR(static_cast<double>((fast.edges[i].time - nominal.edges[i].time).count()), 0.0, 2.0) << i;
}

TEST(SimFrontEnd, ANodesOwnClockShowsInStampsAndInNothingElse) {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  const auto start = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count() - 500'000'000;
  const std::string address = "?rate=1&seconds=60&seed=5&start_ns=" + std::to_string(start);
  const auto device = open(address + "&clock_offset_s=-1000.5&clock_ppm=200");
  const Data own = read(*device, 200);
  const Data bus = read(*open("?rate=max&seconds=60&seed=5"), 20'000);
  const auto shown = [](NodeTime bus_time) {
    return -1000.5e9 + 1.0002 * static_cast<double>(to_ns(bus_time));
  };
  const double bus_s = (to_seconds(own.scans[0].time.time_since_epoch()) + 1000.5) / 1.0002;
  const auto skipped = static_cast<std::size_t>(std::llround(bus_s * 2000.0));
  ASSERT_LT(skipped + 200, bus.scans.size());
  for (std::size_t k = 0; k < 200; ++k) {
    ASSERT_NEAR(static_cast<double>(to_ns(own.scans[k].time)), shown(bus.scans[skipped + k].time), 1.0);
    ASSERT_EQ(own.scans[k].counts, bus.scans[skipped + k].counts);
  }
  EXPECT_NEAR(static_cast<double>((device->begins() - own.scans[0].time).count()), 0.0, 1.0);
  // Its clock, asked for: what was handed over has been converted, and an instant later it shows later.
  const MachineTime machine = MachineClock::now();
  EXPECT_GE(device->node_time(machine), own.scans.back().time);
  const auto elapsed = device->node_time(machine + std::chrono::seconds(10)) - device->node_time(machine);
  // 10 s and 200 ppm; CLOCK_MONOTONIC may be slewed, but reading it twice costs less than 100 us.
  EXPECT_NEAR(to_seconds(elapsed), 10.002, 100e-6);
}

TEST(SimFrontEnd, SeedsMakeOtherCarsAndNodesSeeOneCar) {
  const Data a = read(*open("?rate=max&seconds=1&seed=7"), 2000),
             b = read(*open("?rate=max&seconds=1&seed=7"), 2000);
  const Data c = read(*open("?rate=max&seconds=1&seed=8"), 2000);
  const Data rear = read(*open("?rate=max&seconds=1&seed=7", "rear"), 2000);
  std::size_t differing = 0, rear_differing = 0;
  for (std::size_t k = 0; k < 2000; ++k) {
    ASSERT_EQ(a.scans[k].counts, b.scans[k].counts);
    differing += a.scans[k].counts != c.scans[k].counts;
    rear_differing += a.scans[k].counts != rear.scans[k].counts;
  }
  EXPECT_GT(differing, 1950U);
  EXPECT_GT(rear_differing, 1950U);
}

TEST(SimFrontEnd, BothNodesFeelTheSameBodyMove) {
  // The rigid body has three vertical accelerations; four strut tops on two nodes must agree on them.
  const std::string path = (std::filesystem::temp_directory_path() / "roadbalance_quiet.toml").string();
  std::ofstream(path) << "[[drive.plateau]]\nspeed_km_h = 100\nseconds = 3\n[sensor]\nnoise_m_s2 = 0\n"
                         "coupling_into_vertical = 0\n";
  const Data front = read(*open(path + "?rate=max"), 6000),
             rear = read(*open(path + "?rate=max", "rear"), 6000);
  std::filesystem::remove(path);
  ASSERT_EQ(front.scans.size(), 6000U);
  double largest = 0.0;
  for (std::size_t k = 0; k < front.scans.size(); ++k) {
    const auto& f = front.scans[k].counts;
    const auto& r = rear.scans[k].counts;
    // Same half track in front and rear: left minus right is the same.  Four roundings.
    ASSERT_NEAR(f[8] - f[11], r[8] - r[11], 2.0);
    largest = std::max(largest, std::abs(static_cast<double>(f[8] - f[11])));
  }
  EXPECT_GT(largest, 1000.0);
}

TEST(SimFrontEnd, ReadNeverAllocates) {
  const auto device = open("?rate=max&seconds=3");
  std::vector<Scan> scans(100);
  std::vector<Edge> edges(256);
  std::size_t total = 0;
  {
    const roadbalance::test::NoAllocation guard;
    while (device->read(scans, edges, {}).status == ReadStatus::kOk) ++total;
  }
  EXPECT_GE(total, 60U);
}

void expect_refused(const std::string& address, const std::string& words) {
  try {
    open(address);
    FAIL() << address << " was accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(SimFrontEnd, NamesWhatItCannotUse) {
  expect_refused("?speed=7", "unknown key 'speed'");
  expect_refused("?seed=seven", "seed: 'seven'");
  expect_refused("?rate=0", "rate: '0'");
  expect_refused("?rate=fast", "rate: 'fast'");
  expect_refused("?seconds=", "seconds: ''");
  expect_refused("?seconds=nan", "seconds: 'nan'");
  expect_refused("?from=-1", "from: '-1'");
  expect_refused("?converter_ppm=501", "converter_ppm: '501'");
  expect_refused("?clock_offset_s=nan", "clock_offset_s: 'nan'");
  expect_refused("?clock_ppm=40&rate=max", "clock_ppm: allowed only with rate=1");
  expect_refused("?clock_offset_s=1&rate=20", "clock_offset_s: allowed only with rate=1");
  try {
    open("no/such/scenario.toml?seed=1");
    FAIL() << "opened a file that is not there";
  } catch (const std::system_error& error) {
    EXPECT_NE(std::string(error.what()).find("no/such/scenario.toml"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace roadbalance::sim
