// A zero mark's datum through the command: by a wheel that is turned by hand, and by a trial weight.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <thread>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/config/set_value.hpp"
#include "common/config/text_file.hpp"
#include "common/process/child.hpp"
#include "common/record/record_writer.hpp"
#include "common/test/bus_url.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "firmware/epoch_packer.hpp"
#include "host/analysis/identify/drive_estimator.hpp"
#include "sim/front_end.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

class DatumCommand : public testing::Test {
 protected:
  DatumCommand() { std::ofstream(vehicle_) << test::read_source("sim/demo/vehicle.toml"); }

  /// rb datum with that standard input.
  Child start(const std::string& arguments, const std::string& input) {
    const std::string rb = (std::filesystem::path(std::getenv("RB_BIN")) / "rb").string();
    return {"/bin/sh", {"-c", rb + " datum " + arguments + " < " + input}, folder_ / "rb.log"};
  }
  int wait(Child& child) {
    while (!child.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return *child.ended();
  }
  void wait_for(Child& child, const std::string& words, std::size_t times) {
    const auto said = [&] {
      std::size_t found = 0;
      const std::string log = child.log();
      for (auto at = log.find(words); at != std::string::npos; at = log.find(words, at + 1)) ++found;
      return found;
    };
    while (said() < times && !child.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }

  const test::TemporaryDirectory folder_;
  const std::string vehicle_ = folder_ / "vehicle.toml";
};

/// Seven times on by somewhat more than a turn, in 10 s each.
double by_hand_rad(double time_s) {
  const double cycle = std::floor(time_s / 10.0), part = std::min(1.0, (time_s / 10.0 - cycle) * 2.0);
  return 0.3 + (cycle + part * part * (3.0 - 2.0 * part)) * 381.3 / kDegrees;
}

TEST_F(DatumCommand, LeadsThroughTurningTheWheelAndWritesWhatItFound) {
  constexpr double kDatum_deg = -107.0;
  constexpr int kReadings = 7;
  const std::string url = test::bus_url();
  const sim::PulseTrain train{.angle_rad = by_hand_rad, .line = 1};  // of front_right
  std::ofstream answers(folder_ / "answers");
  for (int n = 1; n <= kReadings; ++n)
    answers << std::lround(std::remainder(by_hand_rad(10.0 * n) * kDegrees + kDatum_deg, 360.0)) << "\n";
  answers.close();
  Child child = start("--wheel front_right --vehicle " + vehicle_ + " --url '" + url + "' --readings " +
                          std::to_string(kReadings) + " --json",
                      folder_ / "answers");
  wait_for(child, "front_right: turn it forward", 1);
  Bus bus(url);
  std::int64_t sequence = 0;
  for (int n = 0; n < kReadings && !child.ended(); ++n) {
    EdgeBlock block;
    const auto send = [&] {
      if (block.empty()) return;
      block.header = {1, 77, ++sequence, 0, 0, block.header.time_ns};
      SealedBlock sealed;
      seal(block, sealed);
      ASSERT_TRUE(bus.publish(block_channel(1, BlockKind::kEdge), sealed.bytes()));
      block = {};
    };
    for (const Edge& edge : train.edges(10.0 * n, 10.0 * n + 9.9))
      if (!block.add(edge)) {
        send();
        block.add(edge);
      }
    send();
    wait_for(child, "datum ", static_cast<std::size_t>(n) + 1);
  }
  ASSERT_EQ(wait(child), 0) << child.log();
  const auto said = nlohmann::json::parse(child.output());
  const double sigma = said["datum_sigma_deg"];
  EXPECT_NEAR(sigma, std::sqrt((3.75 * 3.75 + 1.0) / 12.0 / kReadings), 0.15);
  EXPECT_NEAR(said["datum_deg"], kDatum_deg, 3.0 * sigma);
  EXPECT_NEAR(said["was_deg"], -15.0, 1e-9);
  const VehicleConfig vehicle = VehicleConfig::read_file(vehicle_);
  EXPECT_NEAR(vehicle.wheel[1].encoder.datum_rad * kDegrees, said["datum_deg"], 0.005);
  EXPECT_NEAR(vehicle.wheel[1].encoder.datum_sigma_rad * kDegrees, sigma, 0.01);
  EXPECT_EQ(read_text_file(vehicle_ + ".bak"), test::read_source("sim/demo/vehicle.toml"));
}

TEST_F(DatumCommand, RefusesWhatNobodyCanAnswerOrWrite) {
  const auto refused = [&](const std::string& arguments, const std::string& input, const std::string& says) {
    Child child = start(arguments + " --url '" + test::bus_url() + "'", input);
    EXPECT_EQ(wait(child), 2) << arguments;
    EXPECT_NE(child.log().find(says), std::string::npos) << child.log();
  };
  const std::string left = "--wheel front_left --vehicle " + vehicle_;
  refused(left, "/dev/null", "standard input is a device that nobody types at; allowed: a terminal, a pipe");
  refused(left, "/dev/null 0<&-", "standard input is closed");
  refused("--wheel front_left", vehicle_, "--vehicle FILE");
  refused("--wheel spare --vehicle " + vehicle_, vehicle_,
          "--wheel spare: no wheel with a zero mark; allowed: "
          "front_left");
  refused("--wheel front_left --before a --grams 30", vehicle_, "excludes");
  refused(left + " --grams 30 --at 90", vehicle_, "requires --before");
  Child child = start("--wheel front_left --before a --grams 30", vehicle_);
  EXPECT_EQ(wait(child), 2);
  EXPECT_NE(child.log().find("needs all of --before, --after"), std::string::npos) << child.log();
  refused(left + " --readings 1", vehicle_, "--readings");
  const std::string text = test::read_source("sim/demo/vehicle.toml");
  const std::string table = "[wheel.encoder]\npulses_per_turn = 96\nzero_mark = true\ndatum_deg = 30\n";
  std::ofstream(vehicle_) << std::string(text).replace(text.find(table), table.size(),
                                                       "encoder.pulses_per_turn = 96\n");
  refused(left, vehicle_, "by hand");  // before anybody has turned a wheel
}

/// The demo car at 500 scans a second; the datum of front_left is set.
VehicleConfig car(double datum_deg, double sigma_deg) {
  std::string text = test::read_source("sim/demo/vehicle.toml");
  for (const char* node : {"front", "rear"})
    text = with_value(text, {{"node", node}}, "rate_hz", "500", "car");
  text = with_value(text, {{"filter"}}, "cutoff_hz", "60", "car");
  const TablePath encoder{{"wheel", "front_left"}, {"encoder"}};
  text = with_value(text, encoder, "datum_deg", toml_number(datum_deg, 2), "car");
  return VehicleConfig::parse(with_value(text, encoder, "datum_sigma_deg", toml_number(sigma_deg, 2), "car"),
                              "car");
}

/// The messages of a car whose datum is 30 degrees, described as `told`.
std::vector<SealedBlock> drive(const VehicleConfig& told, const std::string& scenario) {
  const VehicleConfig truth = car(30.0, 0.0);
  std::vector<SealedBlock> blocks;
  for (std::size_t n = 0; n < told.node.size(); ++n) {
    const auto device =
        sim::open_sim_front_end({scenario + "?seed=5&seconds=160&rate=max", truth, truth.node[n]});
    pack_epoch(*device, told, told.node[n], told.node[n].id,
               [&](const SealedBlock& block) { blocks.push_back(block); });
  }
  return blocks;
}

void record(const std::vector<SealedBlock>& blocks, const std::string& folder) {
  RecordWriter writer({.folder = folder});
  for (const SealedBlock& block : blocks) writer.append(block, 1000);
  writer.close();
}

Balance front_left(const VehicleConfig& vehicle, const std::vector<SealedBlock>& blocks) {
  DriveEstimator estimator(vehicle);
  for (const SealedBlock& block : blocks) estimator.consume(block);
  return estimator.estimate().balance[0];
}

TEST_F(DatumCommand, FindsItByATrialWeightAndCountsItsUncertainty) {
  const std::string bare = folder_ / "bare.toml", weighted = folder_ / "weighted.toml";
  const std::string scenario = test::read_source("sim/demo/scenario.toml");
  std::ofstream(bare) << scenario;
  std::ofstream(weighted) << scenario
                          << "\n[[unbalance]]\nwheel = \"front_left\"\nmass_g = 40\nangle_deg = 100\n";
  const VehicleConfig told = car(18.0, 5.0);
  const auto before = drive(told, bare), after = drive(told, weighted);
  record(before, folder_ / "before");
  record(after, folder_ / "after");

  // The datum's uncertainty adds to the angle's, across the unbalance only.
  const Balance exact = front_left(car(18.0, 0.0), before), vague = front_left(told, before);
  ASSERT_EQ(exact.state, Unknown::kNone);
  EXPECT_DOUBLE_EQ(vague.sigma_rad, std::hypot(exact.sigma_rad, 5.0 / kDegrees));
  EXPECT_EQ(vague.sigma_g, exact.sigma_g);
  EXPECT_NEAR((vague.covariance_g2 - exact.covariance_g2).trace(),
              std::pow(exact.unbalance_g * 5.0 / kDegrees, 2), 1e-6);

  const std::string arguments = "--wheel front_left --before " + (folder_ / "before") + " --after " +
                                (folder_ / "after") + " --vehicle " + vehicle_ +
                                " --at 100 --at-sigma-deg 0.5";
  Child child = start(arguments + " --grams 40 --json", "/dev/null");
  ASSERT_EQ(wait(child), 0) << child.log();
  const auto said = nlohmann::json::parse(child.output());
  std::printf("%s", child.output().c_str());
  const double sigma = said["datum_sigma_deg"];
  EXPECT_LT(sigma, 3.0);
  EXPECT_GT(sigma, 0.5);
  EXPECT_NEAR(said["datum_deg"], 30.0, 3.0 * sigma);
  EXPECT_NEAR(said["change_g"], 40.0, 3.0 * said["change_sigma_g"].get<double>());
  EXPECT_NEAR(VehicleConfig::read_file(vehicle_).wheel[0].encoder.datum_rad * kDegrees, said["datum_deg"],
              0.005);

  const std::string written = read_text_file(vehicle_);
  Child wrong = start(arguments + " --grams 50", "/dev/null");
  EXPECT_EQ(wait(wrong), 1);
  EXPECT_NE(wrong.log().find("g of change where 50.0 g were clipped on: the scale is wrong"),
            std::string::npos)
      << wrong.log();
  EXPECT_EQ(read_text_file(vehicle_), written);
}

}  // namespace
}  // namespace roadbalance
