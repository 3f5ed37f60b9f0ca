// The twin beside a recorded drive of the simulated car: whose roads front and rear have a coherence of 0.95.
#include "host/analysis/twin/twin_record.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include "common/record/record_writer.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "firmware/epoch_packer.hpp"
#include "sim/front_end.hpp"
#include "sim/truth.hpp"

namespace roadbalance {
namespace {

constexpr std::uint64_t kSeed = 4;
constexpr double kCoherence2 = 0.95;  // rear_coherence2 of sim/demo/scenario.toml

VehicleConfig slow_car() {
  std::string text = test::read_source("sim/demo/vehicle.toml");
  text = test::replaced(text, "\nrate_hz = 2000", "\nrate_hz = 500");
  text = test::replaced(text, "\ncutoff_hz = 200", "\ncutoff_hz = 100");
  return VehicleConfig::parse(text, "vehicle.toml");
}

class TwinRecord : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_.emplace();
    RecordWriter writer({.folder = *folder_ / "drive"});
    for (const NodeConfig& node : vehicle().node) {
      const auto device = sim::open_sim_front_end(
          {"?seed=" + std::to_string(kSeed) + "&seconds=150&rate=max", vehicle(), node});
      pack_epoch(*device, vehicle(), node, node.id,
                 [&](const SealedBlock& block) { writer.append(block, 1000); });
    }
    writer.close();
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static const VehicleConfig& vehicle() {
    static const VehicleConfig vehicle = slow_car();
    return vehicle;
  }
  static TwinCar true_car() {
    const sim::Truth truth = sim::truth_of("", kSeed, vehicle());
    TwinCar car = TwinCar::nominal(vehicle());
    car.parameters = truth.car.parameters;
    car.rolling_radius_m = truth.car.rolling_radius_m;
    for (std::size_t w = 0; w < kWheels; ++w)
      car.unbalance_kg_m[w] =
          std::polar(1e-3 * truth.wheel[w].unbalance_g * vehicle().wheel[w].weight_radius_m,
                     truth.wheel[w].angle_deg * std::numbers::pi / 180.0);
    return car;
  }
  static RecordedTwin run(std::optional<TwinCar> car, double from_s = 0.0, double to_s = 1e9) {
    return twin_of_record(
        {.folder = *folder_ / "drive", .from_s = from_s, .to_s = to_s, .car = std::move(car)});
  }
  /// For each channel: the share explained of the band around wheel hop, and of all.
  static void print(const char* what, const RecordedTwin& twin) {
    for (std::size_t c = 0; c < twin.total.size(); ++c) {
      const TwinChannels::One& one = twin.channels.channel[c];
      const TwinAccount& account = twin.total[c];
      std::printf("%s %-14s all %.4f of %.4f, 10-25 Hz %.4f of %.4f\n", what,
                  vehicle()
                      .node[static_cast<std::size_t>(one.node)]
                      .channel[static_cast<std::size_t>(one.channel)]
                      .name.c_str(),
                  account.all.share(), account.coherent_all, account.hop.share(), account.coherent_hop);
    }
  }

  static inline std::optional<test::TemporaryDirectory> folder_;
};

TEST_F(TwinRecord, TheTrueCarIsExplainedAsFarAsItsRoadsGoTogether) {
  const RecordedTwin twin = run(true_car());
  print("true", twin);
  // Two signals of one power and coherence g^2 differ by 2 (1 - g) of it; what is not road is
  // explained whole.  Over so few seconds that scatters by about 0.01.
  const double least = 1.0 - 2.0 * (1.0 - std::sqrt(kCoherence2)) - 0.01;
  for (std::size_t c = 0; c < twin.total.size(); ++c) {
    const TwinAccount& account = twin.total[c];
    ASSERT_EQ(account.state, TwinState::kPredicted);
    EXPECT_GT(twin.seconds[c], 130);
    EXPECT_GT(account.hop.share(), least) << c;
    EXPECT_LT(account.hop.share(), account.coherent_hop + 0.01) << c;
    // The body has no road in it.
    if (twin.channels.channel[c].part == TwinPart::kBody) {
      EXPECT_GT(account.all.share(), 0.98) << c;
    }
  }
}

TEST_F(TwinRecord, TheCarThatADriveTellsExplainsAsMuchAsTheTrueOneAndMoreThanTheDescribedOne) {
  const RecordedTwin truth = run(true_car()), found = run(std::nullopt),
                     described = run(TwinCar::nominal(vehicle()));
  print("identified", found);
  print("nominal", described);
  EXPECT_TRUE(found.car.identified);
  EXPECT_EQ(std::ranges::count(found.car.balance, true), kWheels);
  for (std::size_t c = 0; c < found.total.size(); ++c) {
    EXPECT_GT(found.total[c].hop.share(), truth.total[c].hop.share() - 0.01) << c;
    EXPECT_GT(found.total[c].hop.share(), described.total[c].hop.share()) << c;
  }
}

TEST_F(TwinRecord, APartOfADriveIsAccountedForByItself) {
  const RecordedTwin twin = run(true_car(), 20.0, 30.0);
  for (const int seconds : twin.seconds) EXPECT_EQ(seconds, 10);
  const RecordedTwin begin = run(true_car(), 0.0, 2.0);
  for (std::size_t c = 0; c < begin.total.size(); ++c) {
    EXPECT_EQ(begin.seconds[c], 0);
    EXPECT_EQ(begin.total[c].state, TwinState::kSettling);
  }
}

}  // namespace
}  // namespace roadbalance
