// A real car's wheel speeds carry no angle, and identification reports that.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <thread>

#include "common/dbc/candump.hpp"
#include "common/dbc/dbc.hpp"
#include "common/dbc/dbc_reading.hpp"
#include "common/process/child.hpp"
#include "common/record/record_writer.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "firmware/epoch_packer.hpp"
#include "firmware/test/scripted_front_end.hpp"

namespace roadbalance {
namespace {

const std::string kData = "common/dbc/test/data/";
constexpr std::array kSignals{"FL", "FR", "RL", "RR"};

/// The demo car without its encoders; its first node hears the bus.
VehicleConfig car() {
  const std::regex encoder(R"(node = .*\nline = .*\n\[wheel\.encoder\]\n[^\[]*)");
  std::string text = std::regex_replace(test::read_source("sim/demo/vehicle.toml"), encoder, "\n");
  std::string can =
      "[[node.can]]\ninterface = \"can0\"\nrole = \"vehicle\"\ndbc = \"" + kData + "rav4.dbc\"\nsignal = [\n";
  for (std::size_t w = 0; w < kWheels; ++w)
    can += std::string("  {name = \"speed_") + kSignals[w] +
           "\", message = \"WHEEL_SPEEDS\", signal = \"WHEEL_SPEED_" + kSignals[w] +
           "\", quantity = \"wheel_speed\", wheel = \"" + kWheelNames[w] + "\"},\n";
  const std::string rate = "rate_hz = 2000\n";
  return VehicleConfig::parse(text.insert(text.find(rate) + rate.size(), can + "]\n"), "car.toml");
}

class SpeedOnly : public testing::Test {
 protected:
  void SetUp() override {
    const Dbc dbc = Dbc::parse(test::read_source(kData + "rav4.dbc"), "rav4.dbc");
    const DbcMessage& message = *dbc.message("WHEEL_SPEEDS");
    test::ScriptedFrontEnd device(test::marked_scans(0, 120'000, 2000.0), {});
    std::istringstream log(test::read_source(kData + "rav4.candump.log"));
    std::optional<std::int64_t> first_ns;
    for (std::string line; std::getline(log, line);) {
      const LoggedFrame logged = parse_candump(line).value();
      if (!first_ns) first_ns = logged.time_ns;
      if (logged.frame.id != message.id) continue;
      for (std::size_t w = 0; w < kWheels; ++w) {
        const auto reading =
            read_signal(message, *message.signal(std::string("WHEEL_SPEED_") + kSignals[w]), logged.frame);
        device.signals.push_back({node_time_from_ns(logged.time_ns - *first_ns),
                                  static_cast<std::uint16_t>(w), reading.value / 3.6});
      }
    }
    RecordWriter writer({.folder = record_});
    const VehicleConfig vehicle = car();
    pack_epoch(device, vehicle, vehicle.node[0], 7,
               [&](const SealedBlock& block) { writer.append(block, 1000); });
    test::ScriptedFrontEnd rear(test::marked_scans(0, 120'000, 2000.0), {});
    pack_epoch(rear, vehicle, vehicle.node[1], 8,
               [&](const SealedBlock& block) { writer.append(block, 1000); });
    writer.close();
  }
  Child rb(std::vector<std::string> arguments) {
    Child child(std::filesystem::path(std::getenv("RB_BIN")) / "rb", arguments, folder_ / "rb.log");
    while (!child.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return child;
  }

  const test::TemporaryDirectory folder_;
  const std::string record_ = folder_ / "record";
};

TEST_F(SpeedOnly, TheSpeedsAreInTheRecordButIdentificationRefusesAnAngle) {
  const auto info = nlohmann::json::parse(rb({"info", record_, "--json"}).output());
  ASSERT_EQ(info.at("signals").size(), 4U);
  for (const auto& signal : info.at("signals")) EXPECT_EQ(signal.at("samples"), 4974);

  Child said = rb({"identify", record_});
  EXPECT_EQ(said.ended(), 1) << "the answer is no";
  EXPECT_NE(
      said.log().find("front_left, front_right, rear_left, rear_right: the bus tells the wheel's speed only; "
                      "a speed gives orders and magnitudes but carries no angle"),
      std::string::npos)
      << said.log();
  EXPECT_NE(said.output().find("front left:  not known: this wheel has no angle"), std::string::npos)
      << said.output();
  const auto json = nlohmann::json::parse(rb({"identify", record_, "--json"}).output());
  for (const auto& wheel : json.at("wheels")) {
    EXPECT_TRUE(wheel.at("unbalance_g").is_null());
    EXPECT_TRUE(wheel.at("angle_deg").is_null()) << wheel;
  }
}

TEST_F(SpeedOnly, OrdersAreMagnitudesAndHaveNoPhase) {
  Child said = rb({"orders", record_, "--json"});
  EXPECT_EQ(said.ended(), 0) << said.log();
  const auto json = nlohmann::json::parse(said.output());
  ASSERT_EQ(json.at("wheels").size(), kWheels);
  for (const auto& wheel : json.at("wheels")) {
    EXPECT_NE(wheel.at("remark").get<std::string>().find("speed only"), std::string::npos)
        << wheel.at("remark");
    EXPECT_FALSE(wheel.at("angle_located"));
    for (const auto& channel : wheel.at("channels"))
      for (const auto& order : channel.at("orders")) {
        EXPECT_TRUE(order.at("amplitude").is_number());
        EXPECT_TRUE(order.at("phase_deg").is_null());
      }
  }
}

TEST_F(SpeedOnly, TheDistanceCommandGivesBothDistancesAndNoAngle) {
  Child said = rb({"distance", test::source_path(kData + "rav4.candump.log"), "--dbc",
                   test::source_path(kData + "rav4.dbc"), "--counter", "SPEED.ENCODER"});
  EXPECT_EQ(said.ended(), 0) << said.log();
  for (const char* words : {"20900 counts", "1025.1 m", "angle: none"})
    EXPECT_NE(said.output().find(words), std::string::npos) << said.output();
  Child wrong = rb({"distance", test::source_path(kData + "rav4.candump.log"), "--dbc",
                    test::source_path(kData + "rav4.dbc"), "--counter", "SPEED.WHEEL"});
  EXPECT_EQ(wrong.ended(), 2);
  EXPECT_NE(wrong.log().find("SPEED.WHEEL"), std::string::npos) << wrong.log();
}

TEST_F(SpeedOnly, TheDistanceCommandMixesNoTwoBuses) {
  const std::string log = folder_ / "two.log";
  std::ofstream(log) << "(1.000000) can0 0B4#000000001D0B7A5E\n(1.020000) can1 0B4#000000001D0B7A5E\n";
  std::vector<std::string> arguments{
      "distance", log, "--dbc", test::source_path(kData + "rav4.dbc"), "--counter", "SPEED.ENCODER"};
  Child mixed = rb(arguments);
  EXPECT_EQ(mixed.ended(), 2);
  EXPECT_NE(mixed.log().find("can0 and can1"), std::string::npos) << mixed.log();
  arguments.insert(arguments.end(), {"--interface", "can1", "--json"});
  Child chosen = rb(arguments);
  EXPECT_EQ(chosen.ended(), 0) << chosen.log();
  EXPECT_EQ(nlohmann::json::parse(chosen.output()).at("counter").at("messages"), 1);
}

}  // namespace
}  // namespace roadbalance
