// Somebody else's measurement with pulses through rb import and rb orders: two orders of the front left wheel
// at steady 15 turns a second, as an anti-aliasing filter of order 6 at 100 Hz leaves them.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "common/config/text_file.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using Json = nlohmann::json;

constexpr double kRateHz = 500.0, kRotationHz = 15.0, kSeconds = 30.0, kCutoffHz = 100.0;
constexpr int kFilterOrder = 6, kTeeth = 96;
constexpr double kPi = std::numbers::pi, kDegree = kPi / 180.0;
constexpr double kDatumDeg = 30.0;  // of the front left wheel in the demo's vehicle.toml
const Complex kFirst = std::polar(2.0, 75.0 * kDegree), kSecond = std::polar(0.5, -20.0 * kDegree);

/// Butterworth's poles on the circle.
Complex filter(double frequency_hz) {
  Complex product = 1.0;
  for (int k = 1; k <= kFilterOrder; ++k)
    product /= 1.0 - Complex(0.0, frequency_hz / kCutoffHz) /
                         std::polar(1.0, kPi * (2 * k + kFilterOrder - 1) / (2.0 * kFilterOrder));
  return product;
}

class OrdersCommand : public testing::Test {
 protected:
  void SetUp() override {
    std::string text = test::read_source("sim/demo/vehicle.toml");
    text = test::replaced(text, "\nrate_hz = 2000", "\nrate_hz = 500");
    text = test::replaced(text, "\ncutoff_hz = 200", "\ncutoff_hz = 100");
    text +=
        "\n[[rotor]]\nname = \"shaft\"\nwheel = [\"front_left\"]\nratio = 2\n"
        "[[rotor.plane]]\nname = \"flange\"\nposition_m = [0, 0, 0]\nweight_radius_m = 0.05\n";
    std::ofstream(folder_ / "vehicle.toml") << text;
    write_samples(VehicleConfig::parse(text, "vehicle.toml"));
    write_pulses();
    import(record_);
  }
  void import(const std::string& record) {
    const test::Outcome imported =
        rb({"import", "csv", "--samples", folder_ / "samples.csv", "--pulses", folder_ / "pulses.csv",
            "--vehicle", folder_ / "vehicle.toml", "-o", record});
    ASSERT_EQ(imported.code, 0) << imported.log;
  }

  test::Outcome rb(const std::vector<std::string>& arguments) {
    return test::run_rb(arguments, folder_ / "rb.log");
  }

  /// Channel fl_carrier_z has the orders, every other is silent.
  void write_samples(const VehicleConfig& vehicle) {
    std::ofstream file(folder_ / "samples.csv");
    file.precision(12);
    file << "time_s";
    for (const NodeConfig& node : vehicle.node)
      for (const auto& channel : node.channel) file << "," << channel.name;
    file << "\ns";
    for (const NodeConfig& node : vehicle.node)
      for (std::size_t c = 0; c < node.channel.size(); ++c) file << ",m/s^2";
    const Complex first = kFirst * filter(kRotationHz), second = kSecond * filter(2.0 * kRotationHz);
    for (int k = 0; k < std::lround(kSeconds * kRateHz); ++k) {
      const double angle = 2.0 * kPi * kRotationHz * k / kRateHz;
      const double sample = (first * std::polar(1.0, angle) + second * std::polar(1.0, 2.0 * angle)).real();
      file << "\n" << k / kRateHz;
      for (const NodeConfig& node : vehicle.node)
        for (const auto& channel : node.channel)
          file << "," << (channel.name == "fl_carrier_z" ? sample : 0.0);
    }
    file << "\n";
  }
  /// The zero mark fires where the wheel stands at the datum, and the first tooth with it.
  void write_pulses() {
    std::ofstream file(folder_ / "pulses.csv");
    file.precision(12);
    file << "time_s,wheel,kind\n";
    const double first_s = kDatumDeg / 360.0 / kRotationHz;
    for (int k = 0; k < kTeeth * kRotationHz * (kSeconds - 0.1); ++k) {
      const double time_s = first_s + k / (kTeeth * kRotationHz);
      file << time_s << ",front_left,tooth\n";
      if (k % kTeeth == 0) file << time_s << ",front_left,zero\n";
    }
  }

  const test::TemporaryDirectory folder_;
  const std::string record_ = folder_ / "record";
};

TEST_F(OrdersCommand, TellsAmplitudeAndPhaseOfTheOrders) {
  const test::Outcome outcome =
      rb({"orders", record_, "--wheel", "front_left", "--channel", "fl_carrier_z", "--json", "--waterfall"});
  ASSERT_EQ(outcome.code, 0) << outcome.log;
  const Json wheel = Json::parse(outcome.output)["wheels"][0];
  EXPECT_EQ(wheel["wheel"], "front_left");
  EXPECT_NEAR(wheel["seconds"], kSeconds, 0.1);
  const Json channel = wheel["channels"][0];
  EXPECT_EQ(channel["unit"], "m/s^2");
  ASSERT_EQ(channel["orders"].size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const Json order = channel["orders"][i];
    const Complex expected = i == 0 ? kFirst : kSecond;
    // A count of 50 m/s^2 / 2^23 is nothing beside these; the low-pass is right to 2e-4, the imported angle
    // to some thousandths of a degree.
    EXPECT_NEAR(order["amplitude"].get<double>() / std::abs(expected), 1.0, 1e-3) << order;
    EXPECT_NEAR(order["phase_deg"].get<double>(), std::arg(expected) / kDegree, 0.02) << order;
    EXPECT_LT(order["phase_95_deg"].get<double>(), 0.1);
    EXPECT_GT(order["blocks"].get<int>(), 30);
    ASSERT_EQ(order["by_speed"].size(), 1U);
    const double speed_m_s = 2.0 * kPi * 0.30 * kRotationHz;
    EXPECT_LE(order["by_speed"][0]["from_m_s"].get<double>(), speed_m_s);
    EXPECT_GT(order["by_speed"][0]["to_m_s"].get<double>(), speed_m_s);
  }
  ASSERT_EQ(channel["peaks"].size(), 2U);
  EXPECT_NEAR(channel["peaks"][0]["order"], 1.0, 1e-3);
  EXPECT_NEAR(channel["peaks"][0]["amplitude"], 2.0, 0.01);
  EXPECT_NEAR(channel["peaks"][1]["order"], 2.0, 1e-3);
  EXPECT_EQ(channel["waterfall"].size(), 1U);
  EXPECT_EQ(channel["waterfall"][0]["amplitude"], channel["spectrum"]["amplitude"]);
}

TEST_F(OrdersCommand, SaysSoWhereNoAngleIsKnown) {
  // Only the front left wheel has pulses.
  const test::Outcome outcome = rb({"orders", record_, "--wheel", "rear_right", "--json"});
  EXPECT_EQ(outcome.code, 1) << "the answer is no";
  EXPECT_NE(outcome.log.find("known angle"), std::string::npos) << outcome.log;
  const Json wheel = Json::parse(outcome.output)["wheels"][0];
  EXPECT_NEAR(wheel["no_angle_s"], kSeconds, 0.1);
  EXPECT_EQ(wheel["channels"].size(), 12U);
  for (const Json& channel : wheel["channels"]) EXPECT_TRUE(channel["orders"][0]["phase_deg"].is_null());
}

TEST_F(OrdersCommand, PrintsEveryWheelAndChannel) {
  const test::Outcome outcome = rb({"orders", record_});
  EXPECT_EQ(outcome.code, 0) << outcome.log;
  for (const char* text :
       {"front_left, node front", "rear_right, node rear", "fl_carrier_z", "75.0", "peaks  1.00: 2.0"})
    EXPECT_NE(outcome.output.find(text), std::string::npos) << text << "\n" << outcome.output;
}

TEST_F(OrdersCommand, LooksIntoOtherNodesForTheWheelToo) {
  const test::Outcome all = rb({"orders", record_, "--wheel", "front_left", "--all-nodes", "--json"});
  ASSERT_EQ(all.code, 0) << all.log;
  const Json wheels = Json::parse(all.output)["wheels"];
  ASSERT_EQ(wheels.size(), 2U) << "one for each node";
  EXPECT_EQ(wheels[0]["node"], "front");
  EXPECT_EQ(wheels[1]["node"], "rear");
  EXPECT_EQ(wheels[1]["remark"], "");
  EXPECT_NEAR(wheels[1]["seconds"], kSeconds, 0.2);
  for (const Json& channel : wheels[1]["channels"]) {
    EXPECT_GT(channel["orders"][0]["blocks"].get<int>(), 30) << channel["channel"];
    EXPECT_NEAR(channel["orders"][0]["amplitude"], 0.0, 1e-4) << "nothing turns there";
  }
  const test::Outcome one =
      rb({"orders", record_, "--wheel", "front_left", "--channel", "rl_carrier_z", "--json"});
  ASSERT_EQ(one.code, 0) << one.log;
  EXPECT_EQ(Json::parse(one.output)["wheels"][0]["node"], "rear");
}

TEST_F(OrdersCommand, CountsOrdersOfARotorByItsOwnTurns) {
  const test::Outcome outcome =
      rb({"orders", record_, "--rotor", "shaft", "--channel", "fl_carrier_z", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.log;
  const Json shaft = Json::parse(outcome.output)["wheels"][0];
  EXPECT_EQ(shaft["wheel"], "shaft");
  EXPECT_EQ(shaft["ratio"], 2.0);
  EXPECT_EQ(shaft["remark"], "") << "a whole ratio: its angle is known";
  const Json first = shaft["channels"][0]["orders"][0];
  EXPECT_TRUE(first["phase_lasts"]);
  // A turn of the shaft is half a turn of the wheel: its first order is the wheel's second.
  EXPECT_NEAR(first["amplitude"].get<double>() / std::abs(kSecond), 1.0, 1e-3);
  EXPECT_NEAR(first["phase_deg"].get<double>(), std::arg(kSecond) / kDegree, 0.03);
  EXPECT_NEAR(shaft["channels"][0]["peaks"][0]["order"], 0.5, 1e-3)
      << "and the wheel's first is half an order";
}

TEST_F(OrdersCommand, BalancesNoRotorByDrivesThatTellNothingOfIt) {
  const test::Outcome same = rb({"balance", "--rotor", "shaft", record_, record_ + ":flange=20@0", "--json"});
  EXPECT_EQ(same.code, 1) << "the weight did nothing";
  EXPECT_NE(same.log.find("do not tell what a weight"), std::string::npos) << same.log;
  EXPECT_EQ(Json::parse(same.output)["planes"].size(), 0U);
  const test::Outcome wrong = rb({"balance", "--rotor", "shaft", record_, record_ + ":side=20@0"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.log.find("side: rotor shaft has no such plane; allowed: flange"), std::string::npos)
      << wrong.log;
}

TEST_F(OrdersCommand, BalancesNoRotorByDrivesOfVehiclesThatDiffer) {
  std::string text = read_text_file(folder_ / "vehicle.toml");
  text = test::replaced(text, "ratio = 2\n", "ratio = 3\n");
  std::ofstream(folder_ / "vehicle.toml") << text;
  const std::string other = folder_ / "other";
  import(other);
  const test::Outcome refused = rb({"balance", "--rotor", "shaft", record_, other + ":flange=20@0"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.log.find(record_ + " and " + other + " cannot be compared: ratio of shaft is 2 in one"),
            std::string::npos)
      << refused.log;
}

TEST_F(OrdersCommand, NamesWhatIsAtFault) {
  const auto refused = [&](const std::vector<std::string>& arguments, const std::vector<std::string>& texts) {
    std::vector<std::string> all{"orders", record_};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const test::Outcome outcome = rb(all);
    EXPECT_EQ(outcome.code, 2) << outcome.log;
    EXPECT_EQ(outcome.output, "");
    for (const auto& text : texts)
      EXPECT_NE(outcome.log.find(text), std::string::npos) << text << ": " << outcome.log;
  };
  refused({"--wheel", "spare"}, {"spare", "front_left"});
  refused({"--channel", "bonnet_z"}, {"bonnet_z", "fl_carrier_z"});
  refused({"--rotor", "drive_shaft"}, {"drive_shaft", "allowed: shaft"});
  refused({"--rotor", "drive_shaft", "--wheel", "front_left"}, {"--rotor", "--wheel"});
  refused({"--waterfall"}, {"--waterfall requires --json"});
  for (const std::vector<std::string>& of_record :
       {std::vector<std::string>{"--wheel", "front_left"}, {"--order", "7"}, {"--all-nodes"}}) {
    std::vector<std::string> live{"orders", "--live"};
    live.insert(live.end(), of_record.begin(), of_record.end());
    const test::Outcome outcome = rb(live);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.log.find("excludes"), std::string::npos) << outcome.log;
  }
  refused({"--order", "0.01"}, {"--order", "0.01"});
  refused({"--order", "1", "--order", "1.05"}, {"1.05"});
  const test::Outcome nowhere = rb({"orders", folder_ / "nowhere"});
  EXPECT_EQ(nowhere.code, 4);
  EXPECT_NE(nowhere.log.find("nowhere: No such file or directory"), std::string::npos) << nowhere.log;
}

}  // namespace
}  // namespace roadbalance
