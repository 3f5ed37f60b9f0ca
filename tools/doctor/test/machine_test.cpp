#include "tools/doctor/machine.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

// One edge per wake-up of the interrupt thread, sixteen per wake-up of the reader; the ring needs
// 96 * 250 / 3.6 / (2 pi 0.3) = 3537 Hz.
TEST(EncoderEdges, AreSafeUpToWhatTheWorstWakeUpAllows) {
  using std::chrono::microseconds;
  const Finding well =
      encoder_edges({.worst = {.interrupt_thread = microseconds(50), .reader = microseconds(800)},
                     .duration = std::chrono::seconds(30),
                     .realtime = true});
  EXPECT_EQ(well.state, Finding::kWell);
  EXPECT_NE(
      well.sentence.find("in 30 s threads woke up 0.05 ms late at worst where the kernel takes edges one "
                         "by one, 0.80 ms where a node takes up to 16: up to 20.0 kHz"),
      std::string::npos)
      << well.sentence;
  EXPECT_NE(well.sentence.find("needs 3.5 kHz"), std::string::npos) << well.sentence;

  const Finding slow =
      encoder_edges({.worst = {.interrupt_thread = microseconds(400), .reader = microseconds(50)},
                     .duration = {},
                     .realtime = true});
  EXPECT_EQ(slow.state, Finding::kNote);
  EXPECT_NE(slow.sentence.find("up to 2.5 kHz"), std::string::npos) << slow.sentence;
  EXPECT_NE(slow.remedy.find("linux-image-rt"), std::string::npos) << slow.remedy;
  const Finding ordinary =
      encoder_edges({.worst = {.interrupt_thread = microseconds(400), .reader = microseconds(50)},
                     .duration = {},
                     .realtime = false});
  EXPECT_NE(ordinary.remedy.find("rtprio"), std::string::npos) << ordinary.remedy;
}

TEST(EncoderEdges, WakeUpsAreMeasured) {
  const WakeUpMeasurement measured = measure_wake_ups(std::chrono::milliseconds(50));
  EXPECT_GT(measured.worst.interrupt_thread.count(), 0);
  EXPECT_GT(measured.worst.reader.count(), 0);
  EXPECT_EQ(measured.duration, std::chrono::milliseconds(50));
}

TEST(Realtime, TakesPriorityAndLockedMemory) {
  const auto all = realtime({.priority = 50, .locked_bytes = kNoLimit});
  EXPECT_EQ(all.state, Finding::kWell);
  EXPECT_EQ(realtime({.root = true}).state, Finding::kWell);

  // Debian's defaults: no priority, and 8 MiB where a node's ring alone has 16.
  const auto ordinary = realtime({.priority = 0, .locked_bytes = 8 << 20});
  EXPECT_EQ(ordinary.state, Finding::kNote);
  for (const char* part : {"real-time priority", "nor keep its memory in RAM (8 MiB may"})
    EXPECT_NE(ordinary.sentence.find(part), std::string::npos) << ordinary.sentence;
  for (const char* part : {"rtprio 50", "memlock unlimited", "limits.d"})
    EXPECT_NE(ordinary.remedy.find(part), std::string::npos) << ordinary.remedy;

  const auto locked = realtime({.priority = 50, .locked_bytes = 8 << 20});
  EXPECT_EQ(locked.state, Finding::kNote);
  EXPECT_EQ(locked.sentence.find("priority"), std::string::npos) << locked.sentence;
  // Threads that serve a device ask for 45.
  EXPECT_EQ(realtime({.priority = 44, .locked_bytes = kNoLimit}).state, Finding::kNote);
}

TEST(Memory, IsNamedWhereTheProgramsWouldNotHaveEnough) {
  EXPECT_EQ(memory(4e9).state, Finding::kWell);
  EXPECT_EQ(memory(1e8).state, Finding::kNote);
  EXPECT_NE(memory(1e8).sentence.find("0.10 GB"), std::string::npos) << memory(1e8).sentence;
}

class Sys : public testing::Test {
 protected:
  void say(const std::string& file, const std::string& text) {
    const std::filesystem::path path = sys_ / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text << "\n";
  }
  test::TemporaryDirectory sys_;
};

TEST_F(Sys, NamesAProcessorThatIsKeptSlow) {
  EXPECT_FALSE(governor(sys_.path())) << "nothing is told";
  say("devices/system/cpu/cpu0/cpufreq/scaling_driver", "cpufreq-dt");
  say("devices/system/cpu/cpu0/cpufreq/scaling_governor", "schedutil");
  EXPECT_FALSE(governor(sys_.path()));
  say("devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave");
  ASSERT_TRUE(governor(sys_.path()));
  EXPECT_EQ(governor(sys_.path())->state, Finding::kNote);
  // These choose the frequency themselves, and call that so.
  for (const char* driver : {"intel_pstate", "amd-pstate-epp"}) {
    say("devices/system/cpu/cpu0/cpufreq/scaling_driver", driver);
    EXPECT_FALSE(governor(sys_.path())) << driver;
  }
}

TEST_F(Sys, NamesABatteryThatEmpties) {
  EXPECT_FALSE(battery(sys_.path()));
  say("class/power_supply/AC/type", "Mains");
  say("class/power_supply/mouse/type", "Battery");
  say("class/power_supply/mouse/scope", "Device");
  say("class/power_supply/mouse/status", "Discharging");
  say("class/power_supply/BAT0/type", "Battery");
  say("class/power_supply/BAT0/status", "Charging");
  EXPECT_FALSE(battery(sys_.path()));
  say("class/power_supply/BAT0/status", "Discharging");
  say("class/power_supply/BAT0/capacity", "43");
  ASSERT_TRUE(battery(sys_.path()));
  EXPECT_NE(battery(sys_.path())->sentence.find("(43 % left)"), std::string::npos);
}

TEST(WallClock, IsKeptRightOrDatesAreDoubtful) {
  EXPECT_EQ(wall_clock(true).state, Finding::kWell);
  EXPECT_EQ(wall_clock(false).state, Finding::kNote);
  EXPECT_NE(wall_clock(false).sentence.find("dates"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
