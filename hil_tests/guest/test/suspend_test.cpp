#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>

#include "hil_tests/measurement.hpp"

// The guest is suspended while it records: the kernel's own test of suspending, which stops its clocks and
// devices and goes on by itself, for nothing would wake this machine.
namespace roadbalance {
namespace {

double seconds_of(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double slept_s() {
  return seconds_of(CLOCK_BOOTTIME) - seconds_of(CLOCK_MONOTONIC);
}

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
}

class Suspend : public test::Measurement {
 protected:
  /// How long the machine says it slept.
  static double suspend() {
    const double before_s = slept_s();
    write("/sys/module/suspend/parameters/pm_test_delay", "1");
    write("/sys/power/pm_test", "core");
    write("/sys/power/state", "mem");
    return slept_s() - before_s;
  }
};

TEST_F(Suspend, IsAGapOfItsLengthAndCauseAtEachNodeAndANoteOfTheRecorder) {
  test::Program recorder = this->recorder();
  test::Program front = node("front", "rate=1&seconds=10000"), rear = node("rear", "rate=1&seconds=10000");
  ASSERT_TRUE(more_are_durable(kFront, 100) && more_are_durable(kRear, 100));
  const double slept_s = suspend();
  ASSERT_GT(slept_s, 0.5);
  std::printf("slept %.6f s\n", slept_s);
  ASSERT_TRUE(more_are_durable(kFront, 200) && more_are_durable(kRear, 200));
  end_well(recorder, {&front, &rear});
  const Verification found = verify_record(record);
  EXPECT_EQ(found.verdict, Verdict::kIncomplete);
  EXPECT_EQ(verdict_text(found), "incomplete, every gap declared");
  ASSERT_EQ(found.epoch.size(), 2u);
  for (const VerifiedEpoch& epoch : found.epoch) {
    ASSERT_EQ(epoch.gaps.size(), 1u) << "node " << epoch.node;
    EXPECT_EQ(epoch.gaps[0].cause, GapCause::kSlept);
    const double gap_s =
        static_cast<double>(epoch.gaps[0].scans) * static_cast<double>(epoch.period_ps) * 1e-12;
    EXPECT_NEAR(gap_s, slept_s, 1e-3) << "node " << epoch.node;
  }
  EXPECT_TRUE(std::ranges::any_of(found.notes, [](const std::string& note) {
    return note.find("the recorder's computer was suspended for") != std::string::npos;
  }));
  EXPECT_TRUE(found.absent.empty()) << found.absent.front().text;
}

}  // namespace
}  // namespace roadbalance
