#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "common/test/temporary_directory.hpp"
#include "host/recorder/power/power_line.hpp"
#include "host/recorder/power/power_watch.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using Event = PowerWatch::Event;

class SupplyTest : public ::testing::Test {
 protected:
  SupplyTest() { std::filesystem::create_directories(supply); }
  void set(const char* text) { std::ofstream(supply / "online") << text << '\n'; }

  const test::TemporaryDirectory sys;
  const std::filesystem::path supply = sys.path() / "class/power_supply/AC";
  const std::unique_ptr<PowerLine> line = open_power_line("supply:AC", sys.path());
};

TEST_F(SupplyTest, IsWhatTheKernelSays) {
  set("1");
  EXPECT_EQ(line->is_good(), true);
  set("0");
  EXPECT_EQ(line->is_good(), false);
  EXPECT_EQ(line->name(), "supply:AC");
}

TEST_F(SupplyTest, IsNotKnownWithoutTheFileOrWithoutANumberInIt) {
  EXPECT_EQ(line->is_good(), std::nullopt);
  set("yes");
  EXPECT_EQ(line->is_good(), std::nullopt);
  set("-5");
  EXPECT_EQ(line->is_good(), std::nullopt);
  set("1");
  EXPECT_EQ(line->is_good(), true) << "it is asked anew each time";
}

TEST(PowerLine, AGpioChipThatIsNotThereIsNoErrorButTellsNothing) {
  const auto line = open_power_line("gpio:gpiochip99999:3:low");
  EXPECT_EQ(line->is_good(), std::nullopt);
  EXPECT_EQ(line->is_good(), std::nullopt);
}

TEST(PowerLine, NamesTheAddressThatIsNone) {
  for (const char* address :
       {"", "supply", "supply:", "supply:../x", "supply:a:b", "gpio:gpiochip0", "gpio:gpiochip0:x", "gpio::1",
        "gpio:gpiochip0:1:high", "gpio:gpiochip0:-1", "gpio:/dev/gpiochip0:1", "battery:1"}) {
    try {
      open_power_line(address);
      FAIL() << address;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("power line " + std::string(address)), std::string::npos);
    }
  }
}

class PowerWatchTest : public ::testing::Test {
 protected:
  // The events of a constant reading, every 20 ms for so long.
  int hold(std::optional<bool> good, milliseconds duration, Event event) {
    int events = 0;
    for (const WallTime end = now + duration; now < end; now += milliseconds(20)) {
      const Event happened = watch.take(good, now);
      EXPECT_TRUE(happened == Event::kNone || happened == event);
      events += happened == Event::kNone ? 0 : 1;
    }
    return events;
  }
  PowerWatch watch;
  WallTime now{};
};

TEST_F(PowerWatchTest, SaysOnceThatTheSupplyIsGoneAndOnceThatItIsBack) {
  EXPECT_EQ(hold(true, milliseconds(1000), Event::kNone), 0);
  EXPECT_EQ(hold(false, milliseconds(5000), Event::kLost), 1);
  EXPECT_TRUE(watch.on_battery());
  EXPECT_EQ(hold(true, milliseconds(5000), Event::kReturned), 1);
  EXPECT_FALSE(watch.on_battery());
}

TEST_F(PowerWatchTest, IgnoresADipAndAShortComeback) {
  EXPECT_EQ(hold(false, milliseconds(80), Event::kLost), 0);
  EXPECT_EQ(hold(true, milliseconds(20), Event::kNone), 0);
  EXPECT_EQ(hold(false, milliseconds(80), Event::kLost), 0) << "the dips do not add up";
  EXPECT_EQ(hold(false, milliseconds(120), Event::kLost), 1);
  EXPECT_EQ(hold(true, milliseconds(1900), Event::kReturned), 0);
  EXPECT_EQ(hold(false, milliseconds(20), Event::kNone), 0);
  EXPECT_EQ(hold(true, milliseconds(1900), Event::kReturned), 0);
  EXPECT_TRUE(watch.on_battery());
}

TEST_F(PowerWatchTest, KeepsItsStateWhileTheLineCannotBeReadAndSaysSoOnce) {
  hold(false, milliseconds(200), Event::kLost);
  EXPECT_EQ(hold(std::nullopt, milliseconds(980), Event::kNone), 0);
  EXPECT_FALSE(watch.is_unreadable());
  EXPECT_EQ(hold(std::nullopt, milliseconds(10'000), Event::kUnreadable), 1);
  EXPECT_TRUE(watch.is_unreadable());
  EXPECT_TRUE(watch.on_battery());
  EXPECT_EQ(hold(false, milliseconds(1000), Event::kReadable), 1);
  EXPECT_FALSE(watch.is_unreadable());
  EXPECT_TRUE(watch.on_battery());
}

TEST_F(PowerWatchTest, AFailedReadingNowAndThenIsNoEvent) {
  for (int k = 0; k < 100; ++k) {
    EXPECT_EQ(hold(std::nullopt, milliseconds(500), Event::kNone), 0);
    EXPECT_EQ(hold(true, milliseconds(20), Event::kNone), 0);
  }
}

}  // namespace
}  // namespace roadbalance
