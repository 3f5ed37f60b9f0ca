#include "common/config/node_wiring.hpp"

#include <gtest/gtest.h>

#include "common/config/test/refusal.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/test/source.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {
namespace {

using test::expect_refusal;
using test::refusal;

/// The demo car, whose last node gets these keys and tables.
std::string car(const std::string& keys, const std::string& tables) {
  std::string text = test::read_source("sim/demo/vehicle.toml");
  const std::string id = "id = 2\n";
  const auto place = text.find(id);
  EXPECT_NE(place, std::string::npos);
  return text.insert(place + id.size(), keys) + tables;
}

NodeWiring wiring(const std::string& keys, const std::string& tables) {
  return VehicleConfig::parse(car(keys, tables), "car.toml").node.back().wiring;
}

const std::string kTables = R"(
[[node.can]]
interface = "can0"
role = "vehicle"
dbc = "car.dbc"
[[node.can.signal]]
name = "fl_speed"
message = "WHEEL_SPEEDS"
signal = "SPEED_FL"
quantity = "wheel_speed"
wheel = "front_left"
[[node.can.signal]]
name = "speed"
message = "SPEED"
signal = "KMH"
quantity = "vehicle_speed"
[[node.can.signal]]
name = "steering"
message = "STEER"
signal = "ANGLE"
quantity = "steering_angle"
[[node.can]]
interface = "can1"
role = "sensor"
accelerometer_id = 0x120
dbc = "modules.dbc"
[[node.can.signal]]
name = "rr_pulses"
message = "ABS"
signal = "RR"
quantity = "pulse_counter"
wheel = "rear_right"
[[node.can.signal]]
name = "temperature"
message = "AIR"
signal = "DEG_C"
[[node.line]]
line = 1
tooth_gpio = 17
[[node.line]]
line = 0
tooth_gpio = 4
direction_gpio = 5
zero_mark_gpio = 6
)";

const std::string kCounter = R"(
[node.can.signal.counter]
modulus = 256
invalid_code = 255
latency_ms = 12.5
jitter_ms = 2
)";

TEST(NodeWiring, TakesHowAPulseCounterCounts) {
  std::string tables = kTables;
  const std::string wheel = "wheel = \"rear_right\"\n";
  tables.insert(tables.find(wheel) + wheel.size(), kCounter);
  const NodeWiring w = wiring("", tables);
  const SignalConfig& counts = w.can[1].signal[0];
  EXPECT_EQ(counts.counter.modulus, 256);
  EXPECT_EQ(counts.counter.invalid_code, 255);
  EXPECT_EQ(counts.counter.step, 1);
  EXPECT_NEAR(counts.latency.mean_s, 0.0125, 1e-15);
  EXPECT_NEAR(counts.latency.jitter_s, 0.002, 1e-15);
  EXPECT_GE(counts.counter.jitter_s, 3 * counts.latency.jitter_s);

  EXPECT_NE(refusal(car("", kTables + kCounter)).find("counter: only a pulse_counter has one"),
            std::string::npos);
}

TEST(NodeWiring, GivesAWheelTheCounterThatItsEncoderNames) {
  const std::string of_rear_right = "datum_deg = 140";
  const auto with = [&](const std::string& counter) {
    std::string text = car("", kTables);
    const auto place = text.find(of_rear_right);
    EXPECT_NE(place, std::string::npos);
    return text.insert(place, "counter = \"" + counter + "\"\n");
  };
  EXPECT_EQ(VehicleConfig::parse(with("rr_pulses"), "car.toml").wheel[3].encoder.counter, "rr_pulses");
  EXPECT_NE(refusal(with("fl_speed"))
                .find("node rear receives no pulse_counter \"fl_speed\" of this wheel; allowed: rr_pulses"),
            std::string::npos);
}

TEST(NodeWiring, IsEmptyWhereTheFileSaysNothing) {
  const auto vehicle = VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "vehicle.toml");
  const NodeWiring& none = vehicle.node.front().wiring;
  EXPECT_TRUE(none.front_end.empty());
  EXPECT_FALSE(none.loop_back);
  EXPECT_TRUE(none.can.empty());
  EXPECT_TRUE(none.line.empty());
  EXPECT_EQ(none.signals(), 0U);
}

TEST(NodeWiring, TakesDevicesAndLoopBack) {
  const NodeWiring w = wiring("front_end = [\"usb:\", \"can:can0\"]\nloop_back = true\n", "");
  EXPECT_EQ(w.front_end, (std::vector<std::string>{"usb:", "can:can0"}));
  EXPECT_TRUE(w.loop_back);
}

TEST(NodeWiring, NumbersTheSignalsOfAllBusesOneAfterTheOther) {
  const NodeWiring w = wiring("", kTables);
  ASSERT_EQ(w.can.size(), 2U);
  EXPECT_EQ(w.can[0].interface, "can0");
  EXPECT_EQ(w.can[0].role, CanRole::kVehicle);
  EXPECT_EQ(w.can[0].dbc, "car.dbc");
  EXPECT_FALSE(w.can[0].accelerometer_id);
  EXPECT_EQ(w.can[0].first_signal, 0);
  ASSERT_EQ(w.can[0].signal.size(), 3U);
  EXPECT_EQ(w.can[0].signal[0].name, "fl_speed");
  EXPECT_EQ(w.can[0].signal[0].message, "WHEEL_SPEEDS");
  EXPECT_EQ(w.can[0].signal[0].signal, "SPEED_FL");
  EXPECT_EQ(w.can[0].signal[0].quantity, SignalQuantity::kWheelSpeed);
  EXPECT_EQ(w.can[0].signal[0].wheel, "front_left");
  EXPECT_EQ(w.can[0].signal[1].quantity, SignalQuantity::kVehicleSpeed);
  EXPECT_EQ(w.can[0].signal[1].wheel, "");
  EXPECT_EQ(w.can[0].signal[2].quantity, SignalQuantity::kSteeringAngle);
  EXPECT_EQ(w.can[1].role, CanRole::kSensor);
  EXPECT_EQ(w.can[1].accelerometer_id, 0x120U);
  EXPECT_EQ(w.can[1].first_signal, 3);
  ASSERT_EQ(w.can[1].signal.size(), 2U);
  EXPECT_EQ(w.can[1].signal[0].quantity, SignalQuantity::kPulseCounter);
  EXPECT_EQ(w.can[1].signal[0].wheel, "rear_right");
  EXPECT_EQ(w.can[1].signal[1].quantity, SignalQuantity::kOther);
  EXPECT_EQ(w.signals(), 5U);
  EXPECT_EQ(w.signal(2), &w.can[0].signal[2]);
  EXPECT_EQ(w.signal(3), &w.can[1].signal[0]);
  EXPECT_EQ(w.signal(5), nullptr);
  EXPECT_EQ(w.signal(-1), nullptr);
}

TEST(NodeWiring, CallsAQuantityAsTheFileDoes) {
  const NodeWiring w = wiring("", kTables);
  EXPECT_STREQ(name_of(w.signal(0)->quantity), "wheel_speed");
  EXPECT_STREQ(name_of(w.signal(1)->quantity), "vehicle_speed");
  EXPECT_STREQ(name_of(w.signal(2)->quantity), "steering_angle");
  EXPECT_STREQ(name_of(w.signal(3)->quantity), "pulse_counter");
  EXPECT_STREQ(name_of(w.signal(4)->quantity), "other");
}

TEST(NodeWiring, TakesTheWiringOfEncoders) {
  const NodeWiring w = wiring("", kTables);
  ASSERT_EQ(w.line.size(), 2U);
  EXPECT_EQ(w.line[0].line, 1);
  EXPECT_EQ(w.line[0].tooth_gpio, 17);
  EXPECT_FALSE(w.line[0].direction_gpio);
  EXPECT_FALSE(w.line[0].zero_mark_gpio);
  EXPECT_EQ(w.line[1].line, 0);
  EXPECT_EQ(w.line[1].tooth_gpio, 4);
  EXPECT_EQ(w.line[1].direction_gpio, 5);
  EXPECT_EQ(w.line[1].zero_mark_gpio, 6);
  EXPECT_EQ(w.line_at(0), &w.line[1]);
  EXPECT_EQ(wiring("", "").line_at(0), nullptr);
}

TEST(NodeWiring, NamesLineKeyAndWhatIsAllowedOfDevices) {
  std::string many = "front_end = [";
  for (int k = 0; k < 17; ++k) many += "\"can:can" + std::to_string(k) + "\", ";
  const std::string most = "front_end: allowed: at most 16 texts in quotes in [ ]";
  expect_refusal(car(many + "]\n", ""), 0, "front_end", most);
  expect_refusal(car("front_end = \"usb:\"\n", ""), 0, "front_end",
                 "front_end: is 'usb:'; allowed: at most 16 texts in quotes in [ ]");
  expect_refusal(car("front_end = [\"usb:\", 7]\n", ""), 0, "front_end",
                 "front_end: is 7; allowed: at most 16 texts in quotes in [ ]");
  expect_refusal(car("loop_back = 1\n", ""), 0, "loop_back", "loop_back: is 1; allowed: true, false");
}

TEST(NodeWiring, NamesLineKeyAndWhatIsAllowedOfBusesAndLines) {
  struct Case {
    std::string from, to;    ///< change of the tables
    std::string line, says;  ///< where, and the words that follow "car.toml:LINE: "
  };
  const Case cases[] = {
      {"interface = \"can0\"\n", "", "[[node.can]]", "interface: missing; allowed: a text in quotes"},
      {"interface = \"can0\"", "interface = 0", "interface = 0",
       "interface: is 0; allowed: a text in quotes"},
      {"role = \"vehicle\"\n", "", "[[node.can]]", "role: missing; allowed: vehicle, sensor"},
      {"role = \"vehicle\"", "role = \"both\"", "\"both\"", "role: is 'both'; allowed: vehicle, sensor"},
      {"role = \"vehicle\"", "role = \"vehicle\"\naccelerometer_id = 1", "accelerometer_id",
       "accelerometer_id: our modules are on no bus of the car's own; allowed: role = \"sensor\""},
      {"accelerometer_id = 0x120", "accelerometer_id = 0x7FD", "0x7FD",
       "accelerometer_id: is 0x7FD; allowed: an integer 0 .. 2044"},
      {"dbc = \"car.dbc\"\n", "", "[[node.can]]", "dbc: missing, but there are signals it describes"},
      {"dbc = \"car.dbc\"", "dbc = 3", "dbc = 3", "dbc: is 3; allowed: a text in quotes"},
      {"dbc = \"car.dbc\"", "dbc = \"car.dbc\"\nbitrate = 500000", "bitrate",
       "bitrate: unknown key; allowed here: interface, role, dbc, accelerometer_id, signal"},
      {"name = \"fl_speed\"\n", "", "[[node.can.signal]]", "name: missing; allowed: a text in quotes"},
      {"message = \"WHEEL_SPEEDS\"\n", "", "[[node.can.signal]]", "message: missing"},
      {"signal = \"SPEED_FL\"\n", "", "[[node.can.signal]]", "signal: missing"},
      {"\"wheel_speed\"", "\"speed\"", "\"speed\"",
       "quantity: is 'speed'; allowed: wheel_speed, vehicle_speed, steering_angle, pulse_counter, other"},
      {"wheel = \"front_left\"\n", "", "[[node.can.signal]]", "wheel: missing; allowed: front_left, "},
      {"\"front_left\"", "\"spare\"", "\"spare\"",
       "wheel: is 'spare'; allowed: front_left, front_right, rear_left, rear_right"},
      {"quantity = \"vehicle_speed\"", "quantity = \"vehicle_speed\"\nwheel = \"rear_left\"", "\"rear_left\"",
       "wheel: unknown key"},
      {"name = \"temperature\"", "name = \"speed\"", "[[node.can]]", "can: signal \"speed\" stands twice"},
      {"line = 1\n", "", "[[node.line]]", "line: missing; allowed: an integer 0 .. 1"},
      {"line = 1\n", "line = 2\n", "line = 2", "line: is 2; allowed: an integer 0 .. 1"},
      {"line = 1\n", "line = 0\n", "[[node.line]]", "line: line 0 stands twice"},
      {"tooth_gpio = 17\n", "", "[[node.line]]", "tooth_gpio: missing; allowed: an integer 0 .. 1023"},
      {"tooth_gpio = 17", "tooth_gpio = 1024", "1024", "tooth_gpio: is 1024; allowed: an integer 0 .. 1023"},
      {"direction_gpio = 5", "direction_gpio = -1", "direction_gpio = -1",
       "direction_gpio: is -1; allowed: an integer 0 .. 1023"},
      {"direction_gpio = 5", "direction_gpio = 4", "direction_gpio = 4",
       "direction_gpio: GPIO 4 is used twice"},
      {"zero_mark_gpio = 6", "zero_mark_gpio = 17", "zero_mark_gpio = 17",
       "zero_mark_gpio: GPIO 17 is used twice"},
      {"zero_mark_gpio = 6", "zero_mark_gpio = 6\nedge = \"rising\"", "\"rising\"",
       "edge: unknown key; allowed here: line, tooth_gpio, direction_gpio, zero_mark_gpio"},
  };
  for (const Case& c : cases) {
    std::string tables = kTables;
    const auto place = tables.find(c.from);
    ASSERT_NE(place, std::string::npos) << c.from;
    const std::string text = car("", tables.replace(place, c.from.size(), c.to));
    // The demo car may have the same words.
    expect_refusal(text, text.size() - tables.size(), c.line, c.says);
  }
}

TEST(NodeWiring, RefusesMoreSignalsThanASampleCanName) {
  const auto bus_with = [](int signals) {
    std::string tables = "\n[[node.can]]\ninterface = \"can0\"\nrole = \"vehicle\"\ndbc = \"car.dbc\"\n";
    for (int k = 0; k < signals; ++k)
      tables +=
          "[[node.can.signal]]\nname = \"s" + std::to_string(k) + "\"\nmessage = \"M\"\nsignal = \"S\"\n";
    return tables;
  };
  EXPECT_EQ(wiring("", bus_with(kMostSignals)).signals(), 256U);
  EXPECT_NE(refusal(car("", bus_with(kMostSignals + 1))).find("can: has 257 signals; allowed: at most 256"),
            std::string::npos);
}

}  // namespace
}  // namespace roadbalance
