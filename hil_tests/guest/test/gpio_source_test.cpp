#include "firmware/backends/gpio/gpio_source.hpp"

#include <gpiod.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>
#include <vector>

#include "common/config/section.hpp"
#include "common/gpio/edge_limit.hpp"
#include "common/gpio/gpio_chip.hpp"
#include "common/types/clock_pair.hpp"
#include "hil_tests/guest/gpio_rig.hpp"

namespace roadbalance {
namespace {

using test::GpioRig;
using test::hog_processor;
using test::kLead_ns;
using test::PulseChip;

constexpr std::int64_t kPeriod_ns = 50'000;  // 20 kHz

/// From soon on, at 20 kHz.
std::vector<gpio_pulse_step> pulses(unsigned line, int count) {
  return test::pulses(line, PulseChip::now_ns() + kLead_ns, kPeriod_ns, count);
}

std::string refusal(const std::string& chip, LineConfig line) {
  VehicleConfig vehicle{};
  vehicle.node.push_back({.name = "front", .id = 1, .rate_hz = 1000.0, .channel = {}, .wiring = {}});
  vehicle.node[0].wiring.line = {line};
  try {
    open_gpio({chip, vehicle, vehicle.node[0]}, [](const std::string&) {});
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(GpioSource, TwentyThousandEdgesASecondAllArriveWithTrueStamps) {
  GpioRig rig({{0, 3, {}, {}}}, 1000);
  rig.play(pulses(3, 40'000));
  ASSERT_EQ(rig.edges_of(EdgeKind::kTooth), 40'000U) << "declared lost: " << rig.edges_of(EdgeKind::kLost)
                                                     << ", late: " << rig.counted(DeviceCounter::kLateEdges);
  ASSERT_EQ(rig.edges.size(), 40'000U) << "nothing else";
  const std::int64_t machine_ns = machine_minus(CLOCK_MONOTONIC).count();
  std::int64_t worst_ns = 0;
  std::size_t k = 0;
  for (const auto& step : rig.truth)
    if (step.value)
      worst_ns = std::max(
          worst_ns, std::abs(to_ns(rig.edges[k++].time) - machine_ns - static_cast<std::int64_t>(step.t_ns)));
  EXPECT_LE(worst_ns, 1000);
  std::printf("40000 edges at 20 kHz, 0 lost, worst stamp %lld ns from the truth\n",
              static_cast<long long>(worst_ns));
  for (std::size_t c = 0; c < kDeviceCounters; ++c) EXPECT_EQ(rig.counted(DeviceCounter(c)), 0) << c;
}

/// Forward, then backward, as two tracks a quarter of a pitch apart; ends where it began.
TEST(GpioSource, ATransducerInQuadratureSaysWhichWayItTurns) {
  GpioRig rig({{1, 6, 7, {}}}, 1000);
  constexpr int kPitches = 2'000;
  constexpr std::int64_t kQuarter_ns = 50'000;  // 5 kHz
  std::vector<gpio_pulse_step> steps;
  auto at = static_cast<std::uint64_t>(PulseChip::now_ns() + kLead_ns);
  const auto put = [&](unsigned line, unsigned value) {
    steps.push_back({at, line, value});
    at += kQuarter_ns;
  };
  for (int k = 0; k < kPitches; ++k) put(6, 1), put(7, 1), put(6, 0), put(7, 0);
  for (int k = 0; k < kPitches; ++k) put(7, 1), put(6, 1), put(7, 0), put(6, 0);
  rig.play(steps);
  EXPECT_EQ(rig.edges_of(EdgeKind::kTooth, 1), static_cast<std::size_t>(kPitches));
  EXPECT_EQ(rig.edges_of(EdgeKind::kToothBackward, 1), static_cast<std::size_t>(kPitches));
  EXPECT_EQ(rig.edges.size(), 2U * kPitches);
  EXPECT_TRUE(std::ranges::is_sorted(rig.edges, {}, [](const Edge& edge) { return int(edge.kind); }))
      << "all forward ones first";
}

// Between the kernel's interrupt threads (50) and the reader (45): the kernel takes edges that are not read.
TEST(GpioSource, AReaderThatIsKeptFromTheProcessorDeclaresWhatTheKernelDropped) {
  GpioRig rig({{0, 3, {}, {}}}, 1000);
  const auto steps = pulses(3, 8'000);
  const auto middle_ns = static_cast<std::int64_t>(steps[steps.size() / 2].t_ns);
  const auto hog = hog_processor(48, middle_ns, middle_ns + 10'000'000);
  rig.play(steps);
  const std::size_t missing = 8'000 - rig.edges_of(EdgeKind::kTooth);
  EXPECT_NEAR(static_cast<double>(missing), 200.0 - 16.0, 10.0) << "10 ms at 20 kHz, less what was kept";
  EXPECT_GE(rig.counted(DeviceCounter::kEdgesLost), 1);
  // The declaration lies in the hole.
  for (std::size_t k = 1; k < rig.edges.size(); ++k)
    if (rig.edges[k].time - rig.edges[k - 1].time > std::chrono::nanoseconds(2 * kPeriod_ns)) {
      EXPECT_TRUE(rig.edges[k].kind == EdgeKind::kLost || rig.edges[k - 1].kind == EdgeKind::kLost);
    }
  std::printf("%zu of 8000 edges lost in 10 ms, declared %lld time(s)\n", missing,
              static_cast<long long>(rig.counted(DeviceCounter::kEdgesLost)));
}

/// Missing ones of edges at this rate, while ten times no thread of lower priority runs for so long.
std::size_t missing_edges(double rate_hz, int priority, std::chrono::nanoseconds held) {
  GpioRig rig({{0, 3, {}, {}}}, 1000);
  constexpr int kTimes = 10;
  constexpr std::int64_t kApart_ns = 103'000'000;
  const auto count = static_cast<int>(1e-9 * kApart_ns * (kTimes + 1) * rate_hz);
  const auto steps =
      test::pulses(3, PulseChip::now_ns() + kLead_ns, static_cast<std::int64_t>(1e9 / rate_hz), count);
  std::vector<std::jthread> hogs;
  for (int k = 1; k <= kTimes; ++k) {
    const auto from_ns = static_cast<std::int64_t>(steps[0].t_ns) + k * kApart_ns;
    hogs.push_back(hog_processor(priority, from_ns, from_ns + held.count()));
  }
  rig.play(steps);
  return static_cast<std::size_t>(count) - rig.edges_of(EdgeKind::kTooth);
}

// The late thread is, at priority 90, the kernel's interrupt thread (50), at 48 the reader (45).
TEST(GpioSource, UpToTheLimitOfItsWakeUpsNoEdgeIsMissing) {
  using std::chrono::microseconds;
  using std::chrono::milliseconds;
  constexpr WakeUps kInterruptThread{.interrupt_thread = milliseconds(2), .reader = milliseconds(2)};
  constexpr WakeUps kReader{.interrupt_thread = microseconds(50), .reader = milliseconds(20)};
  for (const auto& [priority, late] : {std::pair(90, kInterruptThread), std::pair(48, kReader)}) {
    const double limit_hz = edge_limit_hz(late);
    EXPECT_EQ(missing_edges(0.8 * limit_hz, priority, late.reader), 0U) << priority;
    EXPECT_GT(missing_edges(2.0 * limit_hz, priority, late.reader), 0U) << priority;
  }
}

TEST(GpioSource, AnUnpluggedChipIsSaidToBeGoneAndGivesEdgesAgainWhenItIsBack) {
  GpioRig rig({{0, 3, {}, {}}, {1, 4, {}, {}}});
  rig.play(pulses(3, 100));
  for (int time = 1; time <= 3; ++time) {
    PulseChip::unplug();
    rig.take_until(DeviceCounter::kGone, time);
    EXPECT_EQ(rig.counted(DeviceCounter::kReturned), time - 1);
    PulseChip::plug();
    rig.take_until(DeviceCounter::kReturned, time);
    EXPECT_EQ(rig.counted(DeviceCounter::kGone), time);
    const std::size_t before = rig.edges_of(EdgeKind::kTooth, 1);
    rig.play(pulses(4, 100));
    EXPECT_EQ(rig.edges_of(EdgeKind::kTooth, 1), before + 100);
  }
  for (const std::uint8_t line : std::to_array<std::uint8_t>({0, 1}))
    EXPECT_EQ(rig.edges_of(EdgeKind::kLost, line), 6U) << "gone and back";
}

TEST(GpioSource, SaysOnceWhyAChipThatIsBackCannotBeHad) {
  GpioRig rig({{0, 3, {}, {}}});
  const std::string chip = PulseChip::name();  // it is called otherwise when it is back
  const std::string at_start = rig.warnings;
  PulseChip::unplug();
  rig.take_until(DeviceCounter::kGone, 1);
  PulseChip::plug();
  gpiod_chip* const other = gpiod_chip_open_by_name(PulseChip::name().c_str());
  ASSERT_TRUE(other);
  ASSERT_EQ(gpiod_line_request_input(gpiod_chip_get_line(other, 3), "somebody else"), 0);
  rig.take_for(4'000'000'000);
  EXPECT_EQ(rig.counted(DeviceCounter::kReturned), 0);
  gpiod_chip_close(other);
  rig.take_until(DeviceCounter::kReturned, 1);
  EXPECT_EQ(rig.warnings, at_start + "[[node.line]] line 0 of node " + rig.vehicle.node[0].name +
                              ": tooth_gpio: GPIO 3 of " + chip + ": in use by \"somebody else\"\n");
  rig.play(pulses(3, 100));
  EXPECT_EQ(rig.edges_of(EdgeKind::kTooth), 100U);
}

TEST(GpioSource, AnotherChipOfTheSameLabelIsNotTakenForTheOneThatIsGoneWhichIsFoundBesideIt) {
  const std::string chip = PulseChip::name();
  PulseChip::plug_twin();
  GpioRig rig({{0, 3, {}, {}}});
  const std::string at_start = rig.warnings;
  PulseChip::unplug();
  rig.take_until(DeviceCounter::kGone, 1);
  for (int k = 0; k < 100 && rig.warnings == at_start; ++k) rig.take_for(100'000'000);
  EXPECT_EQ(rig.warnings,
            at_start + "front end gpio:" + chip + ": GPIO chip " + chip + ": No such file or directory\n");
  EXPECT_EQ(rig.counted(DeviceCounter::kReturned), 0);
  PulseChip::plug();
  rig.take_until(DeviceCounter::kReturned, 1);
  rig.play(pulses(3, 100));
  EXPECT_EQ(rig.edges_of(EdgeKind::kTooth), 100U);
  PulseChip::unplug_twin();
}

// The chip that was in use keeps its number on this kernel even when it is gone, so that one of which no line
// was taken stands for those of others.
TEST(GpioChip, OfTwoAlikeThatComeBackInTheOtherOrderIsTheOneThatItWas) {
  PulseChip player;
  PulseChip::unplug();
  PulseChip::plug();  // the kernel gives the lowest number that is free
  PulseChip::plug_twin();
  const std::string own = PulseChip::name(), other = PulseChip::twin_name();
  const GpioChip::Identity identity = GpioChip(own).identity();
  PulseChip::unplug();
  PulseChip::unplug_twin();
  PulseChip::plug_twin();
  ASSERT_EQ(PulseChip::twin_name(), own);
  try {
    const GpioChip twin(own, identity);
    ADD_FAILURE() << "another chip was taken for it";
  } catch (const GpioError& error) {
    EXPECT_EQ(error.what(), "GPIO chip " + own +
                                ": gpio-pulse at /sys/devices/platform/gpio-pulse.1 is called so now, not "
                                "gpio-pulse at /sys/devices/platform/gpio-pulse");
  }
  PulseChip::plug();
  ASSERT_EQ(PulseChip::name(), other);
  GpioChip found(own, identity);
  static_cast<void>(found.take_edges(3, GpioChip::Edges::kRising, "test"));
  player.set(3, true);
  Waiting waiting = Waiting::kNothing;
  found.wait(std::chrono::seconds(1), {&waiting, 1});
  EXPECT_EQ(waiting, Waiting::kEvents);
  player.set(3, false);
  PulseChip::unplug_twin();
}

TEST(GpioSource, WhatCannotBeHadIsRefusedByTheNameOfItsKey) {
  const PulseChip chip;
  EXPECT_EQ(refusal("gpiochip77", {0, 1, {}, {}}),
            "front end gpio:gpiochip77: GPIO chip gpiochip77: No such file or directory");
  EXPECT_EQ(refusal(PulseChip::name(), {0, 1, {}, 40}),
            "[[node.line]] line 0 of node front: zero_mark_gpio: GPIO 40 of " + PulseChip::name() +
                ": no such line; allowed: 0 .. 31");
  gpiod_chip* const other = gpiod_chip_open_by_name(PulseChip::name().c_str());
  ASSERT_TRUE(other);
  ASSERT_EQ(gpiod_line_request_input(gpiod_chip_get_line(other, 9), "somebody else"), 0);
  EXPECT_EQ(refusal(PulseChip::name(), {0, 9, {}, {}}),
            "[[node.line]] line 0 of node front: tooth_gpio: GPIO 9 of " + PulseChip::name() +
                ": in use by \"somebody else\"");
  gpiod_chip_close(other);
  EXPECT_EQ(refusal(PulseChip::name(), {0, 9, {}, {}}), "");
}

}  // namespace
}  // namespace roadbalance
