#include "firmware/board/angle_tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/board/test/check.hpp"

namespace roadbalance::board::test {
namespace {

constexpr std::uint32_t kTickHz = 100'000'000;
constexpr std::uint32_t kTeeth = 96;
constexpr double kSpeedHz = 18.0;
constexpr float kCornerHz = 20.0f;

AngleTracker tracker_at(bool zero_mark = true) {
  AngleTracker tracker;
  tracker.start({kTeeth, kTickHz, kCornerHz, zero_mark});
  return tracker;
}

// In turns from -0.5 to 0.5.
double difference_turns(Phase angle, double truth_turns) {
  const double turns = angle / 4294967296.0 - truth_turns;
  return turns - std::floor(turns + 0.5);
}

// A wheel of angle(t) = speed t + acceleration t^2 / 2 turns; its teeth are at whole pitches + 0.3, its mark
// at 0.
struct Wheel {
  double acceleration_hz_s = 0.0;
  double turns(double s) const { return kSpeedHz * s + 0.5 * acceleration_hz_s * s * s; }
  double time_of(double turns) const {
    if (acceleration_hz_s == 0.0) return turns / kSpeedHz;
    return (std::sqrt(kSpeedHz * kSpeedHz + 2.0 * acceleration_hz_s * turns) - kSpeedHz) / acceleration_hz_s;
  }
  std::uint64_t ticks_of(double turns) const {
    return static_cast<std::uint64_t>(time_of(turns) * kTickHz + 0.5);
  }
  double angle_at(std::uint64_t ticks) const { return turns(static_cast<double>(ticks) / kTickHz); }
};

struct Spoiled {
  int missing_every = 0;  ///< this tooth of as many is missing
  int extra_every = 0;    ///< a pulse that is none comes halfway behind this one
  int extra_mark_every = 0;
  bool stray_mark = false;  ///< one, half a turn off, in the second half
};

// Runs over `turns` turns; returns the largest error in degrees over the second half, at teeth and between.
double largest_error_deg(AngleTracker& tracker, const Wheel& wheel, int turns, const Spoiled& spoiled = {}) {
  double largest = 0.0;
  for (int tooth = 0; tooth < turns * static_cast<int>(kTeeth); ++tooth) {
    if (tooth % static_cast<int>(kTeeth) == 0) {
      const int turn = tooth / static_cast<int>(kTeeth);
      tracker.zero_mark(wheel.ticks_of(turn));
      if (spoiled.extra_mark_every != 0 && turn % spoiled.extra_mark_every == 1)
        tracker.zero_mark(wheel.ticks_of(turn + 0.4 / kTeeth));
    }
    if (spoiled.stray_mark && tooth == (3 * turns + 2) * static_cast<int>(kTeeth) / 4)
      tracker.zero_mark(wheel.ticks_of(static_cast<double>(tooth) / kTeeth));
    const double place = (tooth + 0.3) / kTeeth;
    const std::uint64_t ticks = wheel.ticks_of(place);
    if (spoiled.missing_every == 0 || tooth % spoiled.missing_every != 50) tracker.tooth(ticks, true);
    const std::uint64_t between = wheel.ticks_of(place + 0.4 / kTeeth);
    if (spoiled.extra_every != 0 && tooth % spoiled.extra_every == 70) tracker.tooth(between, true);
    if (tooth < turns * static_cast<int>(kTeeth) / 2) continue;
    CHECK(tracker.locked(between));
    const double error = difference_turns(tracker.angle(between), wheel.angle_at(between)) * 360.0;
    largest = std::max(largest, std::fabs(error));
  }
  return largest;
}

}  // namespace

// The rounding of stamps to 10 ns (6e-5 degrees at 18 Hz) and of the speed to a float remains.
BOARD_TEST(tracker_follows_a_constant_speed_without_error) {
  AngleTracker tracker = tracker_at();
  CHECK_NEAR(largest_error_deg(tracker, Wheel{}, 40), 0.0, 3e-4);
}

// The loop's lag behind a constant acceleration a is a / omega_c^2; one tooth of the filter's step less or
// more. Without a mark the first tooth seen is number 1, though it lies at 0.3.
BOARD_TEST(tracker_lags_behind_an_acceleration_as_theory_has_it) {
  AngleTracker tracker = tracker_at(false);
  const Wheel wheel{10.0};
  const double omega = 2.0 * 3.141592653589793 * static_cast<double>(kCornerHz);
  const double expected_deg = wheel.acceleration_hz_s * 360.0 / (omega * omega);
  constexpr double kFirstToothDeg = 0.7 * 360.0 / kTeeth;
  CHECK_NEAR(kFirstToothDeg - largest_error_deg(tracker, wheel, 40), expected_deg, 0.03 * expected_deg);
}

// The mark is seen through the same loop, so that a lag that stays is no error of the angle.
BOARD_TEST(tracker_takes_a_steady_lag_out_by_the_zero_mark) {
  AngleTracker tracker = tracker_at();
  CHECK_NEAR(largest_error_deg(tracker, Wheel{10.0}, 40), 0.0, 0.01);
}

BOARD_TEST(tracker_numbers_past_a_missing_tooth) {
  AngleTracker tracker = tracker_at();
  CHECK_NEAR(largest_error_deg(tracker, Wheel{}, 40, {.missing_every = 97}), 0.0, 1e-3);
}

BOARD_TEST(tracker_drops_a_pulse_that_no_tooth_can_be) {
  AngleTracker tracker = tracker_at();
  CHECK_NEAR(largest_error_deg(tracker, Wheel{}, 40, {.extra_every = 97}), 0.0, 1e-3);
}

// A mark 0.4 teeth off comes once in eleven marks, and each moves the place by an eighth of what it is off:
// what remains right behind it is 1.5 degrees / 8 / (1 - (7 / 8)^11).
BOARD_TEST(tracker_averages_the_zero_mark) {
  AngleTracker tracker = tracker_at();
  const double largest = largest_error_deg(tracker, Wheel{}, 60, {.extra_mark_every = 10});
  CHECK_NEAR(largest, 0.4 * 360.0 / kTeeth / 8.0 / (1.0 - std::pow(7.0 / 8.0, 11.0)), 0.005);
}

BOARD_TEST(tracker_drops_a_stray_zero_mark) {
  AngleTracker tracker = tracker_at();
  CHECK_NEAR(largest_error_deg(tracker, Wheel{}, 40, {.stray_mark = true}), 0.0, 1e-3);
}

// 97 teeth evenly in one turn are followed as a wheel a percent faster; the mark shows that they were 96.
BOARD_TEST(tracker_takes_a_miscount_out_at_the_next_zero_mark) {
  AngleTracker tracker = tracker_at();
  const std::uint64_t turn = 96 * 50'000;
  std::uint64_t ticks = 0;
  for (int n = 0; n < 20; ++n) {
    const std::uint64_t teeth = n == 18 ? 97 : 96;
    for (std::uint64_t tooth = 0; tooth < teeth; ++tooth) tracker.tooth(ticks + tooth * turn / teeth, true);
    ticks += turn;
    tracker.zero_mark(ticks);
  }
  // The loop, 20 Hz, has followed the step of the speed, and back; what is left of it is far below a tooth.
  CHECK_NEAR(difference_turns(tracker.angle(ticks), 0.0), 0.0, 0.1 / kTeeth);
}

// White noise is scaled by the energy of the impulse response: (1 - r) (1 + 4 r + 5 r^2) / (1 + r)^3.
BOARD_TEST(tracker_reduces_noise_of_the_stamps_by_the_theoretical_factor) {
  constexpr std::uint64_t kPitch = 50'000;
  constexpr std::uint64_t kImpulse = 500;
  const auto run = [](std::uint64_t impulse, std::array<Phase, 400>& angles) {
    AngleTracker tracker = tracker_at(false);
    for (std::uint32_t tooth = 1; tooth <= 600; ++tooth) {
      tracker.tooth(tooth * kPitch - (tooth == 201 ? impulse : 0), true);
      if (tooth > 200) angles[tooth - 201] = tracker.angle(tooth * kPitch);
    }
  };
  static std::array<Phase, 400> clean;
  static std::array<Phase, 400> disturbed;
  run(0, clean);
  run(kImpulse, disturbed);
  double energy = 0.0;
  for (std::size_t k = 0; k < clean.size(); ++k) {
    const double moved = static_cast<std::int32_t>(disturbed[k] - clean[k]) / 4294967296.0 * kTeeth;
    energy += moved * moved / std::pow(static_cast<double>(kImpulse) / kPitch, 2.0);
  }
  const double r = std::exp(-2.0 * 3.141592653589793 * static_cast<double>(kCornerHz) * kPitch / kTickHz);
  const double expected = (1.0 - r) * (1.0 + 4.0 * r + 5.0 * r * r) / std::pow(1.0 + r, 3.0);
  // x = 0.063; the stamp that is a hundredth of a pitch off changes its own steps by as much.
  CHECK_NEAR(energy, expected, 0.03 * expected);
}

BOARD_TEST(tracker_is_not_spoiled_by_two_teeth_at_one_instant) {
  AngleTracker tracker = tracker_at();
  for (int n = 0; n < 3; ++n) tracker.tooth(1'000, true);
  CHECK(std::isfinite(largest_error_deg(tracker, Wheel{}, 40)));
}

BOARD_TEST(tracker_that_missed_many_teeth_needs_its_zero_mark_again) {
  AngleTracker tracker = tracker_at();
  constexpr std::uint64_t kPitch = 50'000;
  std::uint64_t ticks = 0;
  for (int tooth = 0; tooth < 60; ++tooth) tracker.tooth(ticks += kPitch, true);
  tracker.zero_mark(ticks);
  CHECK(tracker.locked(ticks));
  ticks += 20 * kPitch;
  for (int tooth = 0; tooth < 60; ++tooth) tracker.tooth(ticks += kPitch, true);
  CHECK(!tracker.locked(ticks));
  tracker.zero_mark(ticks);
  CHECK(tracker.locked(ticks));
}

BOARD_TEST(tracker_is_not_locked_before_its_zero_mark_nor_after_the_wheel_stopped) {
  AngleTracker tracker = tracker_at();
  const Wheel wheel;
  std::uint64_t ticks = 0;
  for (int tooth = 0; tooth < 60; ++tooth)
    tracker.tooth(ticks = wheel.ticks_of((tooth + 0.3) / kTeeth), true);
  CHECK(!tracker.locked(ticks));
  tracker.zero_mark(ticks + 10);
  CHECK(tracker.locked(ticks + 10));
  const std::uint64_t pitch = wheel.ticks_of(1.0 / kTeeth);
  CHECK(tracker.locked(ticks + 4 * pitch));
  CHECK(!tracker.locked(ticks + 5 * pitch));
  // Turning again it needs teeth and a mark again.
  std::uint64_t later = ticks + kTickHz;
  for (int tooth = 0; tooth < 60; ++tooth) tracker.tooth(later += pitch, true);
  CHECK(!tracker.locked(later));
  tracker.zero_mark(later);
  CHECK(tracker.locked(later));

  AngleTracker markless = tracker_at(false);
  for (int tooth = 0; tooth < 60; ++tooth) markless.tooth(ticks += pitch, true);
  CHECK(markless.locked(ticks));
}

// Back over the same teeth: the same instants the other way round give the angle that was there forward.
BOARD_TEST(tracker_follows_backward_over_the_same_teeth) {
  AngleTracker tracker = tracker_at(false);
  const std::uint64_t pitch = 100'000;
  std::uint64_t ticks = 0;
  std::array<Phase, 400> forward{};
  for (std::size_t tooth = 0; tooth < forward.size(); ++tooth) {
    tracker.tooth(ticks += pitch, true);
    forward[tooth] = tracker.angle(ticks);
  }
  ticks += pitch;
  for (std::size_t tooth = forward.size(); tooth-- > 0;) {
    tracker.tooth(ticks += pitch, false);
    // The loop needs some 1 / omega_c to turn its speed round: 8 ms of these 0.4 s.
    if (tooth < 20)
      CHECK_NEAR(difference_turns(tracker.angle(ticks), forward[tooth] / 4294967296.0), 0.0, 1e-4);
  }
}

}  // namespace roadbalance::board::test
