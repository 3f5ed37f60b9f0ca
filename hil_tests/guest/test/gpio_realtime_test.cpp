#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <stdexcept>

#include "common/angle/wheel_encoder.hpp"
#include "common/test/temporary_directory.hpp"
#include "hil_tests/guest/gpio_rig.hpp"
#include "hil_tests/guest/ring_judge.hpp"
#include "hil_tests/program.hpp"

namespace roadbalance {
namespace {

using test::PulseChip;

// In real time edges may be lost and the player may be late: how much depends on the machine, not on this
// test.  On every machine holds: no turn without all its teeth, and no wrong angle, goes by in silence.

constexpr unsigned kTooth = 3, kMark = 4;
constexpr double kSeconds = 3.0;
constexpr double kFewestTurns = 12.0;
constexpr std::int64_t kFit_ns = 25'000'000;  // half of what an angle is fitted over, and the filter's memory

/// A ring played to a node; prints what became of it.
/// @return angles without a flag that were judged to less than a pitch
std::int64_t expect_no_silence(int teeth, double turns_hz) {
  test::GpioRig rig({{0, static_cast<int>(kTooth), {}, static_cast<int>(kMark)}}, teeth);
  rig.in_real_time = true;
  rig.vehicle.wheel[1].node = "";
  test::RingProgram program{kTooth,   kMark, teeth,
                            turns_hz, 0,     static_cast<int>(std::max(kSeconds * turns_hz, kFewestTurns))};
  program.begin_ns = PulseChip::now_ns() + 200'000'000;
  std::vector<gpio_pulse_step> steps;
  program.add_to(steps);
  steps = test::in_order(std::move(steps));
  rig.play(steps);
  EXPECT_GT(rig.edges.size(), 0U);

  const test::JudgedRing ring{.program = program,
                              .line = 0,
                              .encoder = rig.vehicle.wheel[0].encoder,
                              .filter = rig.vehicle.filter,
                              .machine_minus_monotonic_ns = rig.machine_minus_monotonic_ns};
  const test::PlayedLate late(steps, rig.truth);
  const test::TurnVerdict turns = judge_turns(rig.edges, ring);
  const double pitches_per_ns = 1e-9 * turns_hz * teeth;
  // The place of the ring comes from the two marks before.
  const auto marks_ns = static_cast<std::int64_t>(2e9 / turns_hz);
  const auto allowed = [&](std::int64_t at_ns) {
    return static_cast<double>(late.most_ns(at_ns - marks_ns - kFit_ns, at_ns + kFit_ns)) * pitches_per_ns;
  };
  const test::Sealed sealed = rig.seal(program.begin_ns, (program.turns - 1) / turns_hz);
  const test::AngleVerdict angles = judge_angles(sealed.blocks, ring, allowed);
  std::printf(
      "%d teeth at %.1f turns/s: %zu of %d edges, %lld kLost, %lld faulty turns; %s; %s; the player was late "
      "by %.3f ms at most\n",
      teeth, turns_hz, rig.edges_of(EdgeKind::kTooth), program.turns * teeth,
      static_cast<long long>(rig.edges_of(EdgeKind::kLost)), static_cast<long long>(sealed.faulty_turns),
      turns.text().c_str(), angles.text().c_str(), static_cast<double>(late.most_ns()) * 1e-6);
  EXPECT_EQ(turns.silent, 0);
  EXPECT_EQ(angles.silent_wrong, 0);
  EXPECT_GT(turns.whole + turns.declared, 0);
  return angles.strict;
}

// Half a pitch is 10 ms here.  A machine that is so busy elsewhere that the player is later than that all the
// time gets another chance.
TEST(GpioRealtime, ASlowRingGivesItsAngleAndIsJudgedToLessThanAPitch) {
  std::int64_t strict = 0;
  for (int attempt = 0; attempt < 4 && strict == 0; ++attempt) strict = expect_no_silence(24, 2.0);
  EXPECT_GT(strict, 0);
}

TEST(GpioRealtime, TwoKilohertzOfEdgesAreWholeOrDeclared) {
  static_cast<void>(expect_no_silence(96, 2000.0 / 96));
}

TEST(GpioRealtime, TwentyKilohertzOfEdgesAreWholeOrDeclared) {
  static_cast<void>(expect_no_silence(1000, 20.0));
}

/// `rb doctor`'s result for this machine now: the limit, which must follow from the lateness that it
/// measured.
double limit_by_the_doctor_hz() {
  const test::TemporaryDirectory work;
  const std::string said_file = work.path() / "said";
  test::run(
      "bash",
      {"-c", "exec \"$0\" doctor --folder \"$1\" >\"$2\"", test::binaries() / "rb", work.path(), said_file},
      60);
  std::ifstream file(said_file);
  const std::string said((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  std::smatch found;
  const std::regex sentence(
      "Encoder edges by GPIO: .* woke up ([0-9.]+) ms late .* one by one, ([0-9.]+) ms where .* up to 16: "
      "up to ([0-9.]+) kHz a line");
  if (!std::regex_search(said, found, sentence))
    throw std::runtime_error("rb doctor does not speak of edges: " + said);
  std::printf("%s\n", found.str().c_str());
  const double interrupt_ms = std::stod(found[1]), reader_ms = std::stod(found[2]);
  const double limit_khz = std::stod(found[3]);
  // Both are rounded to 0.01 ms, the limit to 0.1 kHz.
  const auto follows_khz = [&](double off_ms) {
    return std::min(1.0 / std::max(1e-6, interrupt_ms + off_ms), 16.0 / std::max(1e-6, reader_ms + off_ms));
  };
  EXPECT_GE(limit_khz, follows_khz(5e-3) - 0.05);
  EXPECT_LE(limit_khz, follows_khz(-5e-3) + 0.05);
  return 1000.0 * limit_khz;
}

// The limit holds as long as no thread wakes up later than the doctor saw it, which no machine promises: in
// guest time gpio_source_test holds it to that.  Here the share of whole turns is printed.
TEST(GpioRealtime, AtHalfOfWhatTheDoctorSaysTurnsAreWholeOrDeclared) {
  // Where little is safe the ring has fewer teeth, so that its turns do not take too long; where much is,
  // more.
  const double edges_hz = std::max(limit_by_the_doctor_hz() / 2.0, 24.0);
  const int teeth = edges_hz < 2.0 * 96 ? 24 : edges_hz < 40.0 * 96 ? 96 : 1000;
  static_cast<void>(expect_no_silence(teeth, std::min(edges_hz / teeth, 40.0)));
}

}  // namespace
}  // namespace roadbalance
