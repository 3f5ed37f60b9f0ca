#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/bus/results.hpp"
#include "common/config/text_file.hpp"
#include "common/test/source.hpp"
#include "hil_tests/guest/can_player.hpp"
#include "hil_tests/guest/pulse_chip.hpp"
#include "hil_tests/measurement.hpp"
#include "hil_tests/players/drive_comparison.hpp"
#include "host/analysis/drives/identify_record.hpp"

namespace roadbalance {
namespace {

using test::Program;

constexpr double kDegrees = 180.0 / std::numbers::pi;
/// Converters and boards are this far off, each its own: ppm.
constexpr const char* kConverter[] = {"50", "-30"};
constexpr const char* kNode[] = {"front", "rear"};
/// Half of the coarsest code's step in car.dbc: 0.01 km/h, in m/s.
constexpr double kHalfStep = 0.5 * 0.01 / 3.6 + 1e-9;
/// The worst single stamp of an edge is 8 us from the mean, at 17 turns a second: 0.9 mrad.
constexpr double kMostByStamps_rad = 2e-3;
/// The comparison of a drive begins here: every angle is known.
constexpr auto kSettled = std::chrono::seconds(1);

/// How many front-end boards the kernel has enumerated.
std::ptrdiff_t usb_boards() {
  std::ptrdiff_t boards = 0;
  for (const auto& device : std::filesystem::directory_iterator("/sys/bus/usb/devices")) {
    std::string product;
    std::ifstream(device.path() / "product") >> product;
    if (product == "front-end") ++boards;
  }
  return boards;
}

double mean_speed_m_s(const DriveEstimate& estimate) {
  double way_m = 0.0, seconds = 0.0;
  for (const auto& part : estimate.identification.speed_class) {
    way_m += part.speed_m_s * part.seconds;
    seconds += part.seconds;
  }
  return way_m / seconds;
}

/// Recorded by the simulated backend, then played through USB, GPIO and CAN of the guest's kernel into
/// unchanged nodes, and recorded again.
class HilDriveTest : public test::Measurement {
 protected:
  Program simulated_node(int which) const {
    return {"rb-node",
            {"--vehicle", vehicle_file, "--node", kNode[which], "--url", url, "--front-end",
             "sim:" + test::source_path("hil_tests/players/demo/scenario.toml") +
                 "?rate=max&converter_ppm=" + kConverter[which]}};
  }
  Program wired_node(int which) const {
    return {"rb-node", {"--vehicle", vehicle_file, "--node", kNode[which], "--url", url}};
  }

  void record_simulation() {
    Program running = recorder(simulated);
    Program front = simulated_node(0), rear = simulated_node(1);
    EXPECT_EQ(front.exit_code(600), 0);
    EXPECT_EQ(rear.exit_code(600), 0);
    end_well(running, {});
    expect_verified(simulated, 2);
  }

  void record_played_drive() {
    const auto report_file = work.path() / "report.json";
    Program player("rb-play",
                   {"--vehicle", vehicle_file, "--front-end", "replay:" + simulated.string() + "?rate=max",
                    "--lead", "6", "--report", report_file});
    ASSERT_TRUE(test::wait_until([] { return usb_boards() == 2; }, 60)) << "no boards";
    Program running = recorder(played);
    Program analysis("rb-analyser", {"--record", played, "--url", url, "--exit-at-end"});
    Program front = wired_node(0), rear = wired_node(1);
    ASSERT_TRUE(test::wait_until([&] { return std::filesystem::exists(report_file); }, 120));
    end_well(running, {&front, &rear});
    EXPECT_EQ(analysis.exit_code(60), 0);
    bus.listen(0.1);  // it sends its last estimate three times
    player.signal(SIGTERM);
    EXPECT_EQ(player.exit_code(30), 0);
    report = nlohmann::json::parse(std::ifstream(report_file));
  }

  void expect_same(const std::string& node, const test::DriveDifference& difference) const {
    std::printf("%s: scans: %s\n  edges: %s\n  signals: %s\n", node.c_str(), difference.scan.text().c_str(),
                difference.edge.text().c_str(), difference.sample.text().c_str());
    EXPECT_GT(difference.scan.count(), 30'000);
    EXPECT_GT(difference.edge.count(), 2 * 16 * 48 * 30);
    EXPECT_GT(difference.sample.count(), 5 * 100 * 30);
    EXPECT_EQ(difference.scans, 0) << node << ": scans";
    EXPECT_EQ(difference.edges, 0) << node << ": edges";
    EXPECT_EQ(difference.samples, 0) << node << ": samples of signals";
    // Edges are stamped in their interrupt: within a microsecond, but for those that another one holds up.
    EXPECT_LT(std::abs(difference.edge.mean_s()), 1e-6);
    EXPECT_LT(difference.edge.rms_about_mean_s(), 1e-6);
    // Scans by the board's clock, asked for by questions whose two ways differ; the earliest arrivals of
    // packets alone are 30 us late.
    EXPECT_LT(std::abs(difference.scan.mean_s()), 15e-6);
    EXPECT_LT(difference.scan.spread_s(), 10e-6);
    EXPECT_LT(difference.sample.spread_s(), 1e-3);
  }

  /// Stamps that are late by t turn a wheel's angle by its speed times t: the mean of them turns the result,
  /// what is off from the mean by at most s moves its vector by at most speed * s of its length.
  void expect_same_unbalance(const Balance& sim, const Balance& played_one, double speed_rad_s,
                             const test::DriveDifference& difference) const {
    ASSERT_EQ(sim.state, Unknown::kNone);
    ASSERT_EQ(played_one.state, Unknown::kNone);
    const double turn_rad = speed_rad_s * difference.mean_angle_time_s();
    const double most = speed_rad_s * difference.angle_time_spread_s();
    const auto a = std::polar(sim.unbalance_g, sim.angle_rad + turn_rad);
    const auto b = std::polar(played_one.unbalance_g, played_one.angle_rad);
    std::printf(
        "%-11s sim %.3f g %.3f deg (+- %.2f g %.2f deg); played %+.4f g %+.4f deg; stamps explain %+.4f deg "
        "+- %.4f "
        "deg, %.4f g\n",
        kWheelNames[static_cast<std::size_t>(sim.wheel)], sim.unbalance_g, sim.angle_rad * kDegrees,
        sim.sigma_g, sim.sigma_rad * kDegrees, played_one.unbalance_g - sim.unbalance_g,
        std::remainder(played_one.angle_rad - sim.angle_rad, 2.0 * std::numbers::pi) * kDegrees,
        turn_rad * kDegrees, most * kDegrees, most * sim.unbalance_g);
    EXPECT_LT(most, kMostByStamps_rad) << "stamps this bad would explain any result";
    EXPECT_LE(std::abs(b - a), most * sim.unbalance_g);
  }

  /// The last result on the bus of rb-analyser, which followed the record as it grew, equals that of the
  /// finished record to the last bit.
  void expect_published() const {
    const DriveEstimate whole = identify_record(played).estimate;
    const auto said = [&](const char* channel, int wheel) {
      const auto found = bus.results().find({channel, wheel});
      return found == bus.results().end() ? std::vector<std::uint8_t>{} : found->second;
    };
    EXPECT_EQ(said(kIdentificationChannel, 0), encode(whole.identification));
    for (const Balance& balance : whole.balance) {
      EXPECT_EQ(balance.state, Unknown::kNone);
      EXPECT_EQ(said(kBalanceChannel, balance.wheel), encode(balance))
          << kWheelNames[static_cast<std::size_t>(balance.wheel)];
      std::printf("%-11s rb-analyser said %.3f g %.3f deg of the whole drive\n",
                  kWheelNames[static_cast<std::size_t>(balance.wheel)], balance.unbalance_g,
                  balance.angle_rad * kDegrees);
    }
  }

  /// The demo's car on the GPIO chip as it is called now: one that was unplugged came back by another name.
  std::string wire_vehicle() const {
    const std::filesystem::path demo = test::source_path("hil_tests/players/demo");
    std::string text = read_text_file(demo / "vehicle.toml");
    const std::string written = "gpio:gpiochip0";
    for (std::size_t at = 0; (at = text.find(written, at)) != std::string::npos; at += written.size())
      text.replace(at, written.size(), "gpio:" + test::PulseChip::name());
    std::filesystem::copy_file(demo / "car.dbc", work.path() / "car.dbc");
    std::ofstream(work.path() / "vehicle.toml") << text;
    return work.path() / "vehicle.toml";
  }

  const std::string vehicle_file = wire_vehicle();
  const std::filesystem::path simulated = work.path() / "simulated", played = work.path() / "played";
  const test::VirtualCan bus_of_the_car{"vcan0"};
  const VehicleConfig vehicle = VehicleConfig::read_file(vehicle_file);
  nlohmann::json report;
};

TEST_F(HilDriveTest, APlayedDriveGivesTheSimulatedBackendsResult) {
  record_simulation();
  record_played_drive();
  ASSERT_FALSE(HasFailure());
  expect_verified(played, 2);
  for (const std::string& trouble : test::device_troubles(played)) ADD_FAILURE() << trouble;
  std::printf("played: %s\n", report.dump().c_str());

  const test::Timetable timetable{machine_time_from_ns(report["begin_ns"]),
                                  node_time_from_ns(report["first_ns"])};
  std::array<test::DriveDifference, kAxles> difference;
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const NodeConfig& node = vehicle.node[axle];
    difference[axle] = compare(test::recorded_drive(simulated, vehicle, node),
                               test::recorded_drive(played, vehicle, node), timetable, kHalfStep);
    expect_same(node.name, difference[axle]);
  }

  const NodeTime from = timetable.first + kSettled;
  const DriveEstimate expected = test::identify_from(simulated, from);
  const DriveEstimate found = test::identify_from(played, as_node_time(timetable.at(from)));
  EXPECT_EQ(found.identification.sections, expected.identification.sections);
  for (std::size_t w = 0; w < kWheels; ++w)
    expect_same_unbalance(expected.balance[w], found.balance[w],
                          mean_speed_m_s(expected) / vehicle.wheel[w].rolling_radius_m, difference[w / 2]);
  expect_published();
}

}  // namespace
}  // namespace roadbalance
