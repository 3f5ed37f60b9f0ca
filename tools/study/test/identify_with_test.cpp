// `rb identify --estimator`: one recorded drive, put to estimators of different needs.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "common/command_line/exit_code.hpp"
#include "common/record/record_writer.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "firmware/epoch_packer.hpp"
#include "sim/front_end.hpp"
#include "sim/truth.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

constexpr std::uint64_t kSeed = 4;

/// The demo car at 500 scans a second; if `road`, with the road's height in place of the carriers'
/// fore-and-aft accelerations, full scale 1 m.
VehicleConfig car(bool road) {
  std::string text = test::read_source("sim/demo/vehicle.toml");
  text = test::replaced(text, "\nrate_hz = 2000", "\nrate_hz = 500");
  text = test::replaced(text, "\ncutoff_hz = 200", "\ncutoff_hz = 60");
  for (const char* wheel : {"fl", "fr", "rl", "rr"}) {
    const std::string name = std::string("name = \"") + wheel + "_carrier_x\"";
    const auto range = text.find("range_m_s2 = 200", text.find(name));
    if (road) {
      text.replace(range, std::string("range_m_s2 = 200").size(), "range_m_s2 = 1");
      text = test::replaced(text, name, name + "\nrole = \"road\"");
    }
  }
  return VehicleConfig::parse(road ? text + "\n[road]\nmeasured = true\n" : text, "vehicle.toml");
}

class IdentifyWith : public testing::Test {
 protected:
  void drive(const VehicleConfig& vehicle, int seconds) {
    RecordWriter writer({.folder = record_});
    for (const NodeConfig& node : vehicle.node) {
      const auto device = sim::open_sim_front_end(
          {"?seed=" + std::to_string(kSeed) + "&seconds=" + std::to_string(seconds) + "&rate=max", vehicle,
           node});
      pack_epoch(*device, vehicle, node, node.id,
                 [&](const SealedBlock& block) { writer.append(block, 1000); });
    }
    writer.close();
    truth_ = sim::truth_of("", kSeed, vehicle);
  }

  /// Runs rb identify --estimator on the record.
  int identify(const std::string& estimator, bool json = true) {
    std::vector<std::string> arguments{"identify", "--estimator", estimator, record_};
    if (json) arguments.emplace_back("--json");
    const auto [code, output, log] = test::run_rb(arguments, folder_ / "rb.log");
    output_ = output;
    log_ = log;
    if (json && code == kDone) reported_ = nlohmann::json::parse(output_);
    return code;
  }

  /// Each told wheel within a share of the truth, the unbalance as a vector.
  void expect_found(double tyre, double unbalance) {
    ASSERT_EQ(reported_["wheels"].size(), static_cast<std::size_t>(kWheels));
    for (std::size_t w = 0; w < kWheels; ++w) {
      const auto& wheel = reported_["wheels"][w];
      const auto& truth = truth_.wheel[w];
      EXPECT_NEAR(wheel["tyre_stiffness_n_m"].get<double>() / truth.tyre_stiffness_n_m, 1.0, tyre) << w;
      const auto vector = [](double grams, double degrees) {
        return std::polar(grams, degrees * std::numbers::pi / 180.0);
      };
      EXPECT_LT(std::abs(vector(wheel["unbalance_g"], wheel["angle_deg"]) -
                         vector(truth.unbalance_g, truth.angle_deg)),
                unbalance * truth.unbalance_g)
          << w;
    }
  }

  const test::TemporaryDirectory folder_;
  const std::string record_ = folder_ / "record";
  sim::Truth truth_;
  std::string output_, log_;
  nlohmann::json reported_;
};

/// Noise limits it, and how well the drive determines springs and dampers.
TEST_F(IdentifyWith, UsesARoadThatWasMeasured) {
  drive(car(true), 200);
  ASSERT_EQ(identify("windowed-road"), kDone) << log_;
  expect_found(0.02, 0.06);
  EXPECT_GT(reported_["seconds"].get<double>(), 120.0);
  EXPECT_NE(reported_["remarks"].back().get<std::string>().find("for exact"), std::string::npos);
}

TEST_F(IdentifyWith, RefusesWhatNeedsARoadAndFindsWithoutOneWhatDoesNot) {
  drive(car(false), 200);
  EXPECT_EQ(identify("windowed-road"), kUsage);
  EXPECT_NE(log_.find("needs a measured road"), std::string::npos) << log_;
  EXPECT_EQ(identify("guess"), kUsage);
  EXPECT_NE(log_.find("allowed: paper, "), std::string::npos) << log_;

  ASSERT_EQ(identify("own-past-windowed"), kDone) << log_;
  expect_found(0.08, 0.35);
  EXPECT_EQ(reported_["wheels"][0]["tyre_from"], "drive");

  for (const char* name : {"known-tyre", "correlation"}) {
    ASSERT_EQ(identify(name), kDone) << log_;
    for (const auto& wheel : reported_["wheels"]) {
      EXPECT_EQ(wheel["tyre_from"], "vehicle.toml");
      EXPECT_TRUE(wheel["sigma_tyre_stiffness_n_m"].is_null()) << name;
      EXPECT_GT(wheel["tyre_stiffness_n_m"].get<double>(), 2e5) << name;
    }
    const auto remarks = reported_["remarks"].dump();
    EXPECT_NE(remarks.find("± takes the tyres of vehicle.toml for exact"), std::string::npos) << remarks;
    ASSERT_EQ(identify(name, false), kDone);
    EXPECT_NE(output_.find("front_left    tyre  215.0 kN/m as vehicle.toml has it "), std::string::npos)
        << output_;
    EXPECT_EQ(output_.find("nan"), std::string::npos) << output_;
  }
  ASSERT_EQ(identify("chassis"), kDone) << log_;
  for (std::size_t w = 0; w < kWheels; ++w)
    EXPECT_NEAR(reported_["suspension"]["damper_n_s_m"][w]["value"].get<double>() /
                    truth_.car.parameters(kDamper + static_cast<int>(w)),
                1.0, 0.02)
        << w;
  EXPECT_FALSE(reported_.contains("wheels"));
  ASSERT_EQ(identify("chassis", false), kDone);
  EXPECT_NE(output_.find(" N s/m\nstabilisers "), std::string::npos) << output_;
  EXPECT_EQ(output_.find("± 0 "), std::string::npos) << output_;
  EXPECT_EQ(output_.find("± 0.0 "), std::string::npos) << output_;
  ASSERT_EQ(identify("harmonic", false), kDone);
  EXPECT_NE(output_.find("front_left    tyre "), std::string::npos) << output_;
}

}  // namespace
}  // namespace roadbalance
