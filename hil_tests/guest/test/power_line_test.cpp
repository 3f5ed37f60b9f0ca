#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "hil_tests/guest/pulse_chip.hpp"
#include "hil_tests/measurement.hpp"

namespace roadbalance {
namespace {

using test::Program;
using test::PulseChip;

constexpr unsigned kLine = 7;

/// A recorder that watches a line of the guest's GPIO chip, and a node it records.
class PowerLineTest : public test::Measurement {
 protected:
  void SetUp() override {
    chip.set(kLine, true);
    address = "gpio:" + PulseChip::name() + ":" + std::to_string(kLine);
  }
  bool wait_for(bool on_battery, bool unknown) {
    return bus.wait([&] {
      return bus.recorder() && bus.recorder()->on_battery == on_battery &&
             bus.recorder()->power_unknown == unknown;
    });
  }
  /// How many notes of the record have this text of the line.
  std::ptrdiff_t notes(const std::string& words) const {
    return std::ranges::count_if(verify_record(record).notes, [&](const std::string& note) {
      return note.find(words) != std::string::npos && note.find(address) != std::string::npos;
    });
  }

  PulseChip chip;
  std::string address;
};

TEST_F(PowerLineTest, LossAndReturnAreNotedTheSegmentClosedAndADipIgnored) {
  Program running = recorder({"--power", address});
  Program front = node("front", "rate=1&seconds=10000");
  ASSERT_TRUE(more_are_durable(kFront, 20));
  ASSERT_TRUE(wait_for(false, false));

  // A starter motor's dip, shorter than the 100 ms after which the supply is lost.
  const auto begin_ns = static_cast<std::uint64_t>(PulseChip::now_ns());
  const std::vector<gpio_pulse_step> dip{{begin_ns, kLine, 0}, {begin_ns + 50'000'000, kLine, 1}};
  chip.play(dip);
  chip.played();
  ASSERT_TRUE(more_are_durable(kFront, 50));
  EXPECT_FALSE(bus.recorder()->on_battery);
  EXPECT_FALSE(std::filesystem::exists(record / "seg-000001.idx"));

  chip.set(kLine, false);
  ASSERT_TRUE(wait_for(true, false));
  EXPECT_TRUE(bus.wait([&] { return std::filesystem::exists(record / "seg-000001.idx"); }))
      << "the segment is still open";
  ASSERT_TRUE(more_are_durable(kFront, 20)) << "recording goes on, on battery";
  chip.set(kLine, true);
  ASSERT_TRUE(wait_for(false, false));

  end_well(running, {&front});
  expect_verified(record, 1);
  EXPECT_EQ(notes("supply lost"), 1);
  EXPECT_EQ(notes("supply returned"), 1);
  EXPECT_EQ(notes("cannot be read"), 0);
}

TEST_F(PowerLineTest, AnUnpluggedChipIsNotedAndFoundAgain) {
  Program running = recorder({"--power", address});
  Program front = node("front", "rate=1&seconds=10000");
  ASSERT_TRUE(more_are_durable(kFront, 20));
  PulseChip::unplug();
  ASSERT_TRUE(wait_for(false, true));
  ASSERT_TRUE(more_are_durable(kFront, 20)) << "recording matters more";
  PulseChip::plug();
  ASSERT_TRUE(wait_for(false, false));
  chip.set(kLine, false);
  ASSERT_TRUE(wait_for(true, false)) << "the chip is there, but not watched";

  end_well(running, {&front});
  expect_verified(record, 1);
  EXPECT_EQ(notes("cannot be read"), 1);
  EXPECT_EQ(notes("can be read again"), 1);
  EXPECT_EQ(notes("supply lost"), 1);
}

TEST_F(PowerLineTest, ALineThatMeansLossWhenHighIsReadSo) {
  chip.set(kLine, false);
  address += ":low";
  Program running = recorder({"--power", address});
  ASSERT_TRUE(wait_for(false, false));
  chip.set(kLine, true);
  ASSERT_TRUE(wait_for(true, false));
  end_well(running, {});
}

TEST_F(PowerLineTest, ALineThatIsNotThereEndsANewRecordingBeforeItBegins) {
  Program running = recorder({"--power", "gpio:" + PulseChip::name() + ":32"});
  const auto code = running.exit_code(30);
  ASSERT_TRUE(code.has_value());
  EXPECT_NE(*code, 0);
}

}  // namespace
}  // namespace roadbalance
