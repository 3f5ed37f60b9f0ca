#include <gtest/gtest.h>

#include <csignal>
#include <random>

#include "common/bus/compensation.hpp"
#include "common/bus/results.hpp"
#include "hil_tests/measurement.hpp"
#include "host/analysis/drives/identify_record.hpp"

namespace roadbalance {
namespace {

using test::Program;

class AnalyserKill : public test::Measurement {
 protected:
  /// The analyser on the bus has driven enough to identify the car.
  bool is_identified() const {
    const auto said = bus.results().find({kIdentificationChannel, 0});
    if (said == bus.results().end()) return false;
    const auto identification = decode_identification(said->second);
    return identification && identification->state == Unknown::kNone;
  }
};

TEST_F(AnalyserKill, AfterManyKillsTheResultIsBitIdenticalToThatOfTheRecord) {
  const int kills = test::full_run() ? 100 : 8;
  std::mt19937 random(1);
  Program running = recorder();
  // Faster than a measurement, so that there is always something to identify when the kill comes.
  const std::string drive = "rate=30&seconds=10000";
  Program front = node("front", drive), rear = node("rear", drive);
  ASSERT_TRUE(more_are_durable(kFront, 1));
  for (int k = 0; k < kills; ++k) {
    Program killed = analyser();
    bus.listen(1e-3 * std::uniform_int_distribution(0, 400)(random));
    EXPECT_FALSE(killed.exit_code(0)) << "an analyser that had ended by itself";
    killed.kill();
  }
  Program last = analyser({"--exit-at-end"});
  ASSERT_TRUE(more_are_durable(kFront, 1000)) << "the recorder must not care";
  ASSERT_TRUE(bus.wait([&] { return is_identified(); })) << "the drive was too short to compare";
  end_well(running, {&front, &rear});
  bool ended = false;
  ASSERT_TRUE(bus.wait([&] { return ended || (ended = last.exit_code(0) == 0); })) << "the last analyser";
  bus.listen(0.1);
  expect_complete(2);

  const RecordedEstimate recorded = identify_record(record);
  EXPECT_EQ(recorded.estimate.identification.state, Unknown::kNone);
  EXPECT_EQ(bus.results().at({kIdentificationChannel, 0}), encode(recorded.estimate.identification));
  ASSERT_EQ(recorded.estimate.balance.size(), static_cast<std::size_t>(kWheels));
  for (const Balance& balance : recorded.estimate.balance)
    EXPECT_EQ(bus.results().at({kBalanceChannel, balance.wheel}), encode(balance));
  for (const Compensation& compensation : recorded.compensation)
    EXPECT_EQ(bus.results().at({kCompensationChannel, compensation.wheel}), encode(compensation));
}

}  // namespace
}  // namespace roadbalance
