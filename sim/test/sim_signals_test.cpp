#include "sim/signals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "sim/front_end.hpp"
#include "sim/test/test_car.hpp"

namespace roadbalance::sim {
namespace {

constexpr const char* kDrive = "?rate=max&seconds=3&seed=4";

/// The reference car whose front node listens to a bus.
VehicleConfig listening_vehicle() {
  VehicleConfig vehicle = test::reference_vehicle();
  CanConfig can;
  can.interface = "can0";
  can.signal = {{"speed", "CAR", "SPEED", SignalQuantity::kVehicleSpeed, ""},
                {"fl", "WHEELS", "FL", SignalQuantity::kWheelSpeed, "front_left"},
                {"rr", "WHEELS", "RR", SignalQuantity::kWheelSpeed, "rear_right"},
                {"air", "AIR", "TEMPERATURE", SignalQuantity::kOther, ""},
                {"teeth", "ABS", "FR", SignalQuantity::kPulseCounter, "front_right"},
                {"steering", "STEER", "ANGLE", SignalQuantity::kSteeringAngle, ""}};
  vehicle.node[0].wiring.can = {can};
  return vehicle;
}

struct Data {
  std::vector<Scan> scans;
  std::vector<Edge> edges;
  std::vector<SignalSample> signals;
};

Data read(const VehicleConfig& vehicle, const std::string& address, std::size_t signal_room = 64) {
  const auto device = open_sim_front_end({address, vehicle, vehicle.node[0]});
  Data drive;
  std::vector<Scan> scans(100);
  std::vector<Edge> edges(256);
  std::vector<SignalSample> signals(signal_room);
  for (ReadStatus status = ReadStatus::kOk; status == ReadStatus::kOk;) {
    const Read read = device->read(scans, edges, signals);
    drive.scans.insert(drive.scans.end(), scans.data(), scans.data() + read.scans);
    drive.edges.insert(drive.edges.end(), edges.data(), edges.data() + read.edges);
    drive.signals.insert(drive.signals.end(), signals.data(), signals.data() + read.signals);
    status = read.status;
  }
  return drive;
}

TEST(SimSignals, ComeEveryTenMillisecondsButWhatNobodyKnows) {
  const Data drive = read(listening_vehicle(), kDrive);
  ASSERT_EQ(drive.signals.size(), 300U * 5U);
  std::map<std::uint16_t, std::int64_t> next_ns;
  for (const SignalSample& sample : drive.signals) {
    EXPECT_EQ(to_ns(sample.time), next_ns[sample.signal]);
    next_ns[sample.signal] += 10'000'000;
  }
  EXPECT_EQ(next_ns.size(), 5U);
  EXPECT_FALSE(next_ns.contains(3)) << "nobody knows what the temperature is";
}

TEST(SimSignals, ASmallReaderGetsTheSameOnesAndLosesNoScan) {
  const Data all = read(listening_vehicle(), kDrive), little = read(listening_vehicle(), kDrive, 1);
  EXPECT_EQ(all.scans.size(), little.scans.size());
  ASSERT_EQ(all.signals.size(), little.signals.size());
  for (std::size_t k = 0; k < all.signals.size(); ++k) {
    EXPECT_EQ(all.signals[k].time, little.signals[k].time);
    EXPECT_EQ(all.signals[k].signal, little.signals[k].signal);
    EXPECT_EQ(all.signals[k].value, little.signals[k].value);
  }
}

TEST(SimSignals, TellSpeedOfTheCarAndOfItsWheelsByTheRadiusTheCarKnows) {
  const VehicleConfig vehicle = listening_vehicle();
  Scenario scenario = Scenario::read("", vehicle);
  const DrawnCar car = draw_car(scenario, 4, vehicle);
  scenario.scale_to(3.0);
  const Drive drive(scenario.drive, 4);
  for (const SignalSample& sample : read(vehicle, kDrive).signals) {
    const double speed_m_s = drive.at(to_seconds(sample.time.time_since_epoch())).speed_m_s;
    const std::map<std::uint16_t, double> expected{{0, speed_m_s},
                                                   {1, speed_m_s * 0.30 / car.rolling_radius_m[0]},
                                                   {2, speed_m_s * 0.30 / car.rolling_radius_m[3]},
                                                   {5, 0.0}};
    if (const auto known = expected.find(sample.signal); known != expected.end()) {
      EXPECT_NEAR(sample.value, known->second, 1e-9);
    }
  }
}

/// The demo's rings have pitch errors of 0.08 pitches and stamps that jitter by 0.01: five times that is half
/// a pitch, so that counter and edges may differ by one.
TEST(SimSignals, CountTheTeethThatTheEncoderShows) {
  const Data drive = read(listening_vehicle(), kDrive);
  std::size_t next = 0;
  std::int64_t seen = 0, counted = 0;
  double last = -1.0;
  for (const SignalSample& sample : drive.signals) {
    if (sample.signal != 4) continue;
    for (; next < drive.edges.size() && drive.edges[next].time <= sample.time; ++next)
      if (drive.edges[next].line == 1 && drive.edges[next].kind == EdgeKind::kTooth) ++seen;
    if (last >= 0.0) counted += std::llround(sample.value - last + 1024.0) % 1024;
    last = sample.value;
    EXPECT_NEAR(static_cast<double>(counted), static_cast<double>(seen), 1.0);
  }
  EXPECT_GT(counted, 3 * 90);
}

/// The pulse counter of the front right wheel, message by message.
std::vector<double> codes(const CounterForm& form, const CounterLatency& latency) {
  VehicleConfig vehicle = listening_vehicle();
  SignalConfig& teeth = vehicle.node[0].wiring.can[0].signal[4];
  teeth.counter = form;
  teeth.latency = latency;
  std::vector<double> shown;
  for (const SignalSample& sample : read(vehicle, kDrive).signals)
    if (sample.signal == 4) shown.push_back(sample.value);
  return shown;
}

TEST(SimSignals, CountByTheStepsAndWrapThatTheVehicleFileSays) {
  const auto all = codes({.modulus = 1 << 20}, {}), by_steps = codes({.modulus = 240, .step = 4}, {});
  ASSERT_EQ(all.size(), by_steps.size());
  ASSERT_GT(all.back() - all.front(), 3 * 240);
  for (std::size_t k = 0; k < all.size(); ++k)
    EXPECT_EQ(by_steps[k], std::fmod(4.0 * std::floor(all[k] / 4.0), 240.0));
}

TEST(SimSignals, AreAsOldAsTheVehicleFileSays) {
  const auto fresh = codes({.modulus = 1 << 20}, {}), old = codes({.modulus = 1 << 20}, {.mean_s = 0.030}),
             shaken = codes({.modulus = 1 << 20}, {.mean_s = 0.030, .jitter_s = 0.002});
  // Some 15 turns of 96 teeth a second: 43 in 30 ms, 3 in 2 ms; and the first three messages are older.
  double square = 0.0;
  for (std::size_t k = 3; k < fresh.size(); ++k) {
    EXPECT_EQ(old[k], fresh[k - 3]);
    EXPECT_GT(fresh[k] - old[k], 10.0);
    square += std::pow(shaken[k] - old[k], 2) / static_cast<double>(fresh.size() - 3);
  }
  // Two counts, each rounded down, differ by sqrt(1/6) more.
  const double teeth_hz = (fresh.back() - fresh.front()) / (0.01 * static_cast<double>(fresh.size() - 1));
  EXPECT_NEAR(std::sqrt(square), std::hypot(0.002 * teeth_hz, std::sqrt(1.0 / 6.0)), 0.12 * 0.002 * teeth_hz)
      << "297 messages: 4 % are one sigma";
}

TEST(SimSignals, AreStampedByTheNodesClock) {
  const VehicleConfig vehicle = listening_vehicle();
  const auto device =
      open_sim_front_end({"?clock_offset_s=5&clock_ppm=100&seconds=1", vehicle, vehicle.node[0]});
  std::vector<Scan> scans(300);
  std::vector<Edge> edges(256);
  std::vector<SignalSample> signals(64);
  Read got = device->read(scans, edges, signals);
  for (int runs = 0; runs < 20 && got.signals == 0; ++runs) got = device->read(scans, edges, signals);
  ASSERT_GT(got.signals, 0U) << "every second run of 5 ms";
  for (std::size_t k = 0; k < got.signals; ++k) {
    const auto bus_ns = static_cast<double>(to_ns(signals[k].time) - 5'000'000'000) / 1.0001;
    EXPECT_NEAR(bus_ns, 1e7 * std::round(bus_ns / 1e7), 1.0);
  }
}

}  // namespace
}  // namespace roadbalance::sim
