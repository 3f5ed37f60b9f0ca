// Recordings made for it, through rb calibrate channels and rb wiring.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "common/config/set_value.hpp"
#include "common/config/text_file.hpp"
#include "common/dsp/state_filter.hpp"
#include "common/record/record_writer.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "firmware/epoch_packer.hpp"
#include "firmware/test/scripted_front_end.hpp"
#include "sim/front_end.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

class CalibrationCommands : public testing::Test {
 protected:
  CalibrationCommands() { std::ofstream(vehicle_file_) << text_; }

  test::Outcome rb(const std::vector<std::string>& arguments) {
    return test::run_rb(arguments, folder_ / "rb.log");
  }
  void record(FrontEnd& device, const VehicleConfig& vehicle, const NodeConfig& node) {
    RecordWriter writer({.folder = record_});
    pack_epoch(device, vehicle, node, 9, [&](const SealedBlock& block) { writer.append(block, 1000); });
    writer.close();
  }

  const test::TemporaryDirectory folder_;
  const std::string record_ = folder_ / "record", vehicle_file_ = folder_ / "vehicle.toml";
  const std::string text_ = test::read_source("sim/demo/vehicle.toml");
};

/// One noise on twelve inputs: the filter of the third is 1 % low, the fourth hears another noise, the rest
/// differ by nothing.
std::vector<Scan> one_signal_on_all(double seconds, double rate_hz) {
  constexpr int kSteps = 4;
  std::vector<StateFilter> filters;
  for (int c = 0; c < kAccelerations; ++c)
    filters.emplace_back(
        discretise_ramp_invariant(butterworth(6, c == 2 ? 198.0 : 200.0), 1.0 / (rate_hz * kSteps)), 1);
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 0.2);
  std::vector<Scan> scans(static_cast<std::size_t>(seconds * rate_hz));
  for (std::size_t k = 0; k < scans.size(); ++k) {
    for (int step = 0; step < kSteps; ++step) {
      const double all = normal(random), other = normal(random);
      for (std::size_t c = 0; c < kAccelerations; ++c)
        filters[c].update(Eigen::Array<double, 1, 1>(c == 3 ? other : all));
    }
    scans[k].index = static_cast<std::int64_t>(k);
    scans[k].time = node_time_from_ns(std::llround(static_cast<double>(k) * 1e9 / rate_hz));
    for (std::size_t c = 0; c < kAccelerations; ++c)
      scans[k].counts[c] =
          static_cast<std::int32_t>(std::lround(filters[c].states()(0, 0) * kFullScaleCounts));
  }
  return scans;
}

TEST_F(CalibrationCommands, ChannelsAreSetInTheVehicleFileAndOneWithoutTheSignalIsNot) {
  const VehicleConfig vehicle = VehicleConfig::parse(text_, "car");
  test::ScriptedFrontEnd device(one_signal_on_all(30.0, 2000.0), {});
  record(device, vehicle, vehicle.node[0]);
  const std::vector<std::string> arguments{"calibrate", "channels",  record_,       "--node",
                                           "front",     "--vehicle", vehicle_file_, "--json"};
  const test::Outcome outcome = rb(arguments);
  EXPECT_EQ(outcome.code, 1) << "one is left as it is";
  EXPECT_NE(outcome.log.find("fl_strut_x is left as it is: it does not show the signal"), std::string::npos)
      << outcome.log;
  const Json channels = Json::parse(outcome.output)["nodes"][0]["channels"];
  ASSERT_EQ(channels.size(), 12U);
  EXPECT_EQ(channels[3]["verdict"], "no coherence");
  EXPECT_TRUE(channels[3]["gain"].is_null());

  const VehicleConfig after = VehicleConfig::read_file(vehicle_file_);
  // 3.8637 / (2 pi) (1 / 198 - 1 / 200) s behind the others.
  const double lag_s = 3.8637 / (2.0 * std::numbers::pi) * (1.0 / 198.0 - 1.0 / 200.0);
  EXPECT_NEAR(after.node[0].channel[2].delay_s, lag_s, 0.02 * lag_s);
  EXPECT_NEAR(after.node[0].channel[0].delay_s, 0.0, 1e-9);
  EXPECT_NEAR(after.node[0].channel[0].scale_m_s2_per_count * kFullScaleCounts, 200.0, 0.002);
  EXPECT_EQ(after.node[0].channel[3].delay_s, 0.0);
  EXPECT_EQ(read_text_file(vehicle_file_ + ".bak"), text_);

  EXPECT_EQ(rb({"calibrate", "channels", record_, "--node", "spare"}).code, 2);
  EXPECT_EQ(rb({"calibrate", "channels", record_, "--reference-channel", "spare"}).code, 2);
  const test::Outcome by_one =
      rb({"calibrate", "channels", record_, "--reference-channel", "fl_strut_z", "--json"});
  const Json of_nodes = Json::parse(by_one.output)["nodes"];
  ASSERT_EQ(of_nodes.size(), 1U) << "the rear node has no such channel";
  EXPECT_EQ(of_nodes[0]["channels"].size(), 12U) << by_one.log;
  const test::Outcome silent = rb({"calibrate", "channels", record_, "--node", "rear"});
  EXPECT_EQ(silent.code, 1);
  EXPECT_NE(silent.log.find("0 s could be compared"), std::string::npos) << silent.log;
}

TEST_F(CalibrationCommands, WiringSaysWhatAgreesAndWhatIsProbablyWrong) {
  const std::string with = with_value(text_, {{"node", "front"}}, "loop_back", "true", "car");
  const VehicleConfig right = VehicleConfig::parse(with, "car");
  const VehicleConfig wrong =
      VehicleConfig::parse(with_value(with, {{"filter"}}, "cutoff_hz", "190", "car"), "car");
  for (const VehicleConfig* fitted : {&right, &wrong}) {
    std::filesystem::remove_all(record_);
    const auto device = sim::open_sim_front_end({"?seed=3&seconds=40&rate=max", *fitted, fitted->node[0]});
    record(*device, right, right.node[0]);
    const test::Outcome outcome = rb({"wiring", record_, "--json"});
    EXPECT_EQ(outcome.code, fitted == &right ? 0 : 1) << outcome.log;
    const Json wheels = Json::parse(outcome.output)["wheels"];
    ASSERT_EQ(wheels.size(), 2U);
    for (const Json& wheel : wheels) {
      EXPECT_EQ(wheel["good"], fitted == &right) << wheel;
      const double error_deg = wheel["angle_error_deg"];
      if (fitted == &right) {
        EXPECT_LT(std::abs(error_deg), 0.02) << wheel;
      } else {
        EXPECT_LT(error_deg, -1.0) << wheel;
        EXPECT_NE(wheel["cause"].get<std::string>().find("than the filter of vehicle.toml"),
                  std::string::npos);
      }
    }
    const test::Outcome words = rb({"wiring", record_});
    EXPECT_NE(words.output.find(fitted == &right ? "good: angle off by" : "WRONG: angle off by"),
              std::string::npos)
        << words.output;
  }
}

TEST_F(CalibrationCommands, WiringDoesNotCallWrongWhatItCouldNotTest) {
  std::string text = with_value(text_, {{"node", "front"}}, "loop_back", "true", "car");
  text = with_value(text, {{"wheel", "front_left"}, {"encoder"}}, "zero_mark", "false", "car");
  const VehicleConfig vehicle = VehicleConfig::parse(text, "car");
  const auto device = sim::open_sim_front_end({"?seed=3&seconds=3&rate=max", vehicle, vehicle.node[0]});
  record(*device, vehicle, vehicle.node[0]);
  const test::Outcome outcome = rb({"wiring", record_, "--json"});
  EXPECT_EQ(outcome.code, 1) << "nothing is proven";
  const Json wheels = Json::parse(outcome.output)["wheels"];
  ASSERT_EQ(wheels.size(), 2U);
  for (const Json& wheel : wheels) {
    EXPECT_EQ(wheel["tested"], false);
    const bool marked = wheel["wheel"] != "front_left";
    EXPECT_NE(wheel["cause"].get<std::string>().find(marked ? "drive a little" : "no zero mark"),
              std::string::npos)
        << wheel;
  }
  const test::Outcome words = rb({"wiring", record_});
  EXPECT_NE(words.output.find("front_left   not tested\n"), std::string::npos) << words.output;
  EXPECT_EQ(words.output.find("WRONG"), std::string::npos);
}

TEST_F(CalibrationCommands, WiringNeedsALoopBack) {
  const VehicleConfig vehicle = VehicleConfig::parse(text_, "car");
  test::ScriptedFrontEnd device(one_signal_on_all(1.0, 2000.0), {});
  record(device, vehicle, vehicle.node[0]);
  const test::Outcome outcome = rb({"wiring", record_});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.log.find("no node has a loop-back"), std::string::npos) << outcome.log;
}

}  // namespace
}  // namespace roadbalance
