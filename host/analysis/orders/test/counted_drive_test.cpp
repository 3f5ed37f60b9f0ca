// A simulated drive whose front wheels' teeth are counted on the bus, recorded, and analysed as rb orders and
// rb identify do it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <optional>
#include <regex>

#include "common/config/section.hpp"
#include "common/record/record_writer.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "firmware/epoch_packer.hpp"
#include "host/analyser/live_orders.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/analysis/orders/angle_uncertainty.hpp"
#include "host/analysis/orders/orders_of_record.hpp"
#include "sim/front_end.hpp"

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

enum class Teeth { kOnLine, kOnBus, kOnBusWithoutMark, kNowhere };

/// The demo car; its front node hears a bus that counts every 10 ms.
VehicleConfig car(Teeth teeth) {
  std::string text = test::read_source("sim/demo/vehicle.toml");
  std::string can = "[[node.can]]\ninterface = \"can0\"\nrole = \"vehicle\"\ndbc = \"car.dbc\"\n";
  for (const std::string wheel : {"front_left", "front_right"})
    can += "[[node.can.signal]]\nname = \"" + wheel + "_pulses\"\nmessage = \"ABS\"\nsignal = \"" + wheel +
           "\"\nquantity = \"pulse_counter\"\nwheel = \"" + wheel +
           "\"\n[node.can.signal.counter]\nmodulus = 256\ninvalid_code = 256\n";
  const std::string rate = "rate_hz = 2000\n";
  const auto node = text.find(rate);
  EXPECT_NE(node, std::string::npos);
  text.insert(node + rate.size(), can);
  if (teeth == Teeth::kNowhere) {
    // No wheel has an encoder, and the bus carries the speed of one.
    text.insert(text.find(rate) + rate.size(),
                "[[node.can]]\ninterface = \"can1\"\nrole = \"vehicle\"\ndbc = \"car.dbc\"\n"
                "[[node.can.signal]]\nname = \"fl_speed\"\nmessage = \"ABS\"\nsignal = \"V\"\n"
                "quantity = \"wheel_speed\"\nwheel = \"front_left\"\n");
    const std::regex encoder(R"(node = .*\nline = .*\n\[wheel\.encoder\]\n[^\[]*)");
    return VehicleConfig::parse(std::regex_replace(text, encoder, "\n"), "car.toml");
  }
  if (teeth == Teeth::kOnLine) return VehicleConfig::parse(text, "car.toml");
  std::size_t place = 0;
  for (const std::string wheel : {"front_left", "front_right"}) {
    const std::string key = "zero_mark = true\n";
    place = text.find(key, text.find("name = \"" + wheel + "\"", place));
    EXPECT_NE(place, std::string::npos);
    text.replace(place, key.size(),
                 std::string("zero_mark = ") + (teeth == Teeth::kOnBus ? "true" : "false") +
                     "\ncounter = \"" + wheel + "_pulses\"\n");
  }
  return VehicleConfig::parse(text, "car.toml");
}

const char* const kDrive =
    "[drive]\nwander_km_h = 0.5\n"
    "[[drive.plateau]]\nspeed_km_h = 100.0\nseconds = 60.0\n[[drive.plateau]]\nspeed_km_h = 120.0\nseconds = "
    "60.0\n"
    "[road]\nclass = \"A\"\n"
    "[[unbalance]]\nwheel = \"front_left\"\nmass_g = 30.0\nangle_deg = 75.0\n"
    "[[unbalance]]\nwheel = \"front_right\"\nmass_g = 20.0\nangle_deg = 200.0\n"
    "[spread]\nparameters = 0.0\n";

class CountedDrive : public testing::Test {
 protected:
  std::string record(Teeth teeth, double seconds) {
    const VehicleConfig vehicle = car(teeth);
    return record(vehicle, vehicle, seconds, std::to_string(static_cast<int>(teeth)));
  }
  /// @param described  the vehicle by the record
  std::string record(const VehicleConfig& vehicle, const VehicleConfig& described, double seconds,
                     const std::string& name) {
    std::ofstream(folder_ / "scenario.toml") << kDrive;
    const std::string record = folder_ / ("record" + name);
    RecordWriter writer({.folder = record});
    for (const NodeConfig& node : vehicle.node) {
      const auto front_end = sim::open_sim_front_end(
          {folder_ / "scenario.toml?seed=5&rate=max&seconds=" + std::to_string(seconds), vehicle, node});
      pack_epoch(*front_end, described, node, node.id,
                 [&](const SealedBlock& block) { writer.append(block, 1000); });
    }
    writer.close();
    return record;
  }
  const test::TemporaryDirectory folder_;
};

TEST_F(CountedDrive, HasTheOrdersThatTheRingTellsWithinWhatIsStated) {
  const WantedOrders wanted{.wheel = "front_left", .channel = "fl_carrier_z"};
  const RecordOrders ring = orders_of_record(record(Teeth::kOnLine, 60.0), wanted);
  const RecordOrders counter = orders_of_record(record(Teeth::kOnBus, 60.0), wanted);
  EXPECT_TRUE(ring.angle.empty());
  ASSERT_TRUE(counter.angle.contains(0));
  const AngleReprocessor::Quality quality = counter.angle.at(0);
  EXPECT_TRUE(quality.located);
  EXPECT_GT(quality.marks, 800);
  const MeanVector expected = ring.rotor[0]->vectors().result(0, 0).all;
  const MeanVector found = counter.rotor[0]->vectors().result(0, 0).all;
  const double off_rad = std::arg(found.mean() / expected.mean());
  std::printf("amplitude off by %+.3f %%, phase by %+.3f degrees; sigma of an angle %.3f, of the mean %.3f\n",
              100.0 * (std::abs(found.mean() / expected.mean()) - 1.0), off_rad / kDegree,
              quality.sigma_rad / kDegree, quality.common_sigma_rad / kDegree);
  EXPECT_NEAR(std::abs(found.mean() / expected.mean()), 1.0, 0.01);
  EXPECT_LT(std::abs(off_rad), 3.0 * quality.common_sigma_rad + 0.1 * kDegree);
  EXPECT_LT(quality.common_sigma_rad, 0.3 * kDegree);
  EXPECT_GT(counter.rotor[0]->seconds().recorded, 59.0);
  EXPECT_LT(counter.rotor[0]->seconds().no_angle, 1.0);
}

TEST_F(CountedDrive, LiveOrdersAreThoseOfTheFinishedRecording) {
  const std::string folder = record(Teeth::kOnLine, 40.0);
  std::optional<LiveOrders> live;
  read_recording(
      folder, [&](const VehicleConfig& vehicle) { live.emplace(vehicle); },
      [&](const SealedBlock& block) { live->consume(block); });
  const RecordOrders finished = orders_of_record(folder, {.all_nodes = true});
  int compared = 0;
  for (const OrderReport& report : live->reports())
    for (const auto& rotor : finished.rotor) {
      if (rotor->rotor().wheel.front() != report.wheel || rotor->node().id != report.node) continue;
      for (std::size_t c = 0; c < rotor->channel().size(); ++c) {
        const MeanVector expected = rotor->vectors().result(static_cast<int>(c), 0).all;
        const OrderReport::Vector& found = report.order[0][rotor->channel()[c]];
        // Its low-pass loses the first 24 ms, and so perhaps a turn: N blocks of 8 turns each then lie a turn
        // later.  Noise of n a turn makes that 1.4 n / (8 N) beside 95 % at 1.7 n / sqrt(8 N): 0.29 /
        // sqrt(N).
        const double shifted = 0.29 / std::sqrt(static_cast<double>(expected.count()));
        EXPECT_LT(std::abs(found.value - expected.mean()), 2.5 * shifted * expected.confidence()->amplitude);
        EXPECT_NEAR(found.blocks, expected.count(), 1);
        EXPECT_GT(expected.count(), 50);
        ++compared;
      }
    }
  EXPECT_EQ(compared, 4 * 24) << "four wheels in the twelve channels of two nodes";
}

TEST_F(CountedDrive, WithoutAMarkHasMagnitudesAndNoPhase) {
  const WantedOrders wanted{.wheel = "front_left", .channel = "fl_carrier_z"};
  const std::string folder = record(Teeth::kOnBusWithoutMark, 60.0);
  const RecordOrders counter = orders_of_record(folder, wanted);
  EXPECT_FALSE(counter.angle.at(0).located);
  EXPECT_EQ(counter.rotor[0]->rotor().known_share, 0.0);
  EXPECT_FALSE(counter.rotor[0]->vectors().has_phase(0));
  const MeanVector found = counter.rotor[0]->vectors().result(0, 0).all;
  const RecordOrders ring = orders_of_record(record(Teeth::kOnLine, 60.0), wanted);
  const MeanVector expected = ring.rotor[0]->vectors().result(0, 0).all;
  EXPECT_NEAR(std::abs(found.mean()) / std::abs(expected.mean()), 1.0, 0.02);

  const RecordedEstimate identified = identify_record(folder);
  EXPECT_NE(identified.estimate.balance[0].state, Unknown::kNone);
  EXPECT_NE(identified.refusal.find("front_left, front_right: the bus counts pulses but sends no zero mark"),
            std::string::npos)
      << identified.refusal;
}

TEST_F(CountedDrive, WhoseMarksContradictOneAnotherIsAsGoodAsOneWithout) {
  const VehicleConfig vehicle = car(Teeth::kOnBus);
  const auto wrong = VehicleConfig::parse(
      std::regex_replace(vehicle.text, std::regex("pulses_per_turn = 96"), "pulses_per_turn = 95"), "wrong");
  const std::string folder = record(vehicle, wrong, 60.0, "wrong");
  const RecordOrders counter = orders_of_record(folder, {.wheel = "front_left", .channel = "fl_carrier_z"});
  ASSERT_EQ(counter.vehicle.wheel[0].encoder.pulses_per_turn, 95);
  EXPECT_FALSE(counter.angle.at(0).located);
  // Its marks walk round the ring by a tooth a turn, 1000 turns long.
  EXPECT_GT(counter.angle.at(0).marks_dropped, 10 * counter.angle.at(0).marks);
  const Rotor& rotor = counter.rotor[0]->rotor();
  EXPECT_EQ(rotor.known_share, 0.0);
  EXPECT_FALSE(counter.rotor[0]->vectors().has_phase(0));
  EXPECT_GT(counter.rotor[0]->vectors().result(0, 0).all.count(), 50) << "magnitudes there are";
  const AngleUncertainty uncertainty = angle_uncertainty(counter, rotor);
  EXPECT_FALSE(uncertainty.located);
  EXPECT_NE(uncertainty.contradiction.find("front_left: of its"), std::string::npos)
      << uncertainty.contradiction;
  EXPECT_NE(uncertainty.contradiction.find("is pulses_per_turn right?"), std::string::npos);

  const RecordedEstimate identified = identify_record(folder);
  EXPECT_NE(identified.estimate.balance[0].state, Unknown::kNone);
  EXPECT_NE(identified.refusal.find("front_left: of its"), std::string::npos) << identified.refusal;
}

TEST_F(CountedDrive, WhoseRingHasNoMarkIsCountedByItsTeethAndNotByTheSpeedOfTheBus) {
  std::string text = car(Teeth::kOnLine).text;
  const std::string rate = "rate_hz = 2000\n", mark = "zero_mark = true\n";
  text.insert(text.find(rate) + rate.size(),
              "[[node.can]]\ninterface = \"can1\"\nrole = \"vehicle\"\ndbc = \"car.dbc\"\n"
              "[[node.can.signal]]\nname = \"fl_speed\"\nmessage = \"ABS\"\nsignal = \"V\"\n"
              "quantity = \"wheel_speed\"\nwheel = \"front_left\"\n");
  const auto marked = VehicleConfig::parse(text, "marked");
  text.replace(text.find(mark, text.find("name = \"front_left\"")), mark.size(), "zero_mark = false\n");
  const auto bare = VehicleConfig::parse(text, "bare");
  ASSERT_FALSE(bare.wheel[0].encoder.zero_mark);
  const WantedOrders wanted{.wheel = "front_left", .channel = "fl_carrier_z"};
  const RecordOrders ring = orders_of_record(record(marked, marked, 60.0, "marked"), wanted);
  const RecordOrders teeth = orders_of_record(record(bare, bare, 60.0, "bare"), wanted);
  ASSERT_TRUE(teeth.angle.contains(0));
  EXPECT_FALSE(teeth.angle.at(0).by_speed);
  EXPECT_FALSE(teeth.angle.at(0).located);
  EXPECT_FALSE(teeth.rotor[0]->vectors().has_phase(0));
  const MeanVector expected = ring.rotor[0]->vectors().result(0, 0).all;
  const MeanVector found = teeth.rotor[0]->vectors().result(0, 0).all;
  EXPECT_GT(found.count(), 100);
  // The speed's rolling radius would let it run away; a ring error of 0.3 degrees is nothing.
  EXPECT_NEAR(std::abs(found.mean()) / std::abs(expected.mean()), 1.0, 0.005);
}

TEST_F(CountedDrive, OfWhichTheBusTellsTheSpeedOnlyHasASpectrumAndNoPhase) {
  const RecordOrders ring =
      orders_of_record(record(Teeth::kOnLine, 60.0), {.wheel = "front_left", .channel = "fl_carrier_z"});
  const RecordOrders speed = orders_of_record(record(Teeth::kNowhere, 60.0), {.channel = "fl_carrier_z"});
  ASSERT_EQ(speed.rotor.size(), 1U) << "of the other wheels nothing is known";
  EXPECT_TRUE(speed.angle.at(0).by_speed);
  EXPECT_FALSE(speed.angle.at(0).located);
  EXPECT_FALSE(speed.rotor[0]->vectors().has_phase(0));
  const auto expected = ring.rotor[0]->waterfall().spectrum(0).amplitude;
  const auto found = speed.rotor[0]->waterfall().spectrum(0).amplitude;
  // The simulated bus uses the rolling radius: the first order is line 32.
  EXPECT_NEAR(found.at(32) / expected.at(32), 1.0, 0.02);
  EXPECT_THROW(orders_of_record(folder_ / "record3", {.wheel = "rear_left"}), ConfigError);
}

TEST_F(CountedDrive, IsIdentifiedWithItsDoubt) {
  const RecordedEstimate found = identify_record(record(Teeth::kOnBus, 120.0));
  const auto& balance = found.estimate.balance[0];
  ASSERT_EQ(balance.state, Unknown::kNone) << found.refusal;
  const double off = std::remainder(balance.angle_rad - 75.0 * kDegree, 2.0 * std::numbers::pi);
  std::printf("%.2f +- %.2f g at %.2f +- %.2f degrees\n", balance.unbalance_g, balance.sigma_g,
              balance.angle_rad / kDegree, balance.sigma_rad / kDegree);
  EXPECT_NEAR(balance.unbalance_g, 30.0, 3.0 * balance.sigma_g);
  EXPECT_LT(std::abs(off), 3.0 * balance.sigma_rad);
  EXPECT_LT(balance.sigma_rad, 3.0 * kDegree);
}

}  // namespace
}  // namespace roadbalance
