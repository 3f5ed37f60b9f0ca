#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/board/board.hpp"
#include "firmware/board/test/check.hpp"
#include "firmware/board/test/rig.hpp"

// The references' whole way: encoder, tracking loop, D/A, anti-aliasing filter, converter; beside it an
// acceleration through the same filter.
namespace roadbalance::board::test {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kSpeedHz = 18.0;            // 120 km/h
constexpr std::uint32_t kStepTicks = 1'000;  // the analogue world in steps of 10 us
constexpr std::uint32_t kDacTicks = 5'000;   // D/A at 20 kHz
constexpr std::array<double, kLines> kTeeth = {96.0, 1000.0};
constexpr double kDatumTurns = 0.125;

// Butterworth of order 4: two sections of the bilinear transform, Q = 0.5412 and 1.3066.
class Filter {
 public:
  explicit Filter(double corner_hz) {
    const double k = std::tan(kPi * corner_hz * kStepTicks / kTickHz);
    for (std::size_t n = 0; n < 2; ++n) {
      const double q = n == 0 ? 0.541196100146197 : 1.306562964876377;
      const double norm = 1.0 / (1.0 + k / q + k * k);
      sections_[n] = {k * k * norm, 2.0 * (k * k - 1.0) * norm, (1.0 - k / q + k * k) * norm, 0.0, 0.0};
    }
  }
  double step(double x) {
    for (Section& s : sections_) {
      const double y = s.gain * x + s.z1;
      s.z1 = 2.0 * s.gain * x - s.a1 * y + s.z2;
      s.z2 = s.gain * x - s.a2 * y;
      x = y;
    }
    return x;
  }

 private:
  struct Section {
    double gain, a1, a2, z1, z2;
  };
  std::array<Section, 2> sections_{};
};

double turns_at(std::uint64_t ticks) {
  return kSpeedHz * static_cast<double>(ticks) / kTickHz;
}

// One wheel's analogue channels: sine and cosine as truth, and as the D/A has them.
struct Channels {
  std::array<Filter, 4> filters;
  std::array<double, 4> out{};
};

struct World {
  Rig& rig = Rig::fresh();
  std::array<Channels, kLines> wheels;
  std::array<std::int64_t, kLines> teeth{};
  std::int64_t marks = 0;
  double amplitude = 0.0;

  explicit World(double corner_hz)
      : wheels{{{{Filter(corner_hz), Filter(corner_hz), Filter(corner_hz), Filter(corner_hz)}},
                {{Filter(corner_hz), Filter(corner_hz), Filter(corner_hz), Filter(corner_hz)}}}} {}

  // Teeth of wheel k lie at whole pitches + 0.3, the zero mark at 0.
  void pass_edges(std::uint64_t until) {
    const double turns = turns_at(until);
    for (std::size_t k = 0; k < kLines; ++k) {
      if (turns >= static_cast<double>(marks) && k == 0) {
        for (std::size_t line = 0; line < kLines; ++line)
          rig.board.line_change(line, Signal::kZero, true, until);
        ++marks;
      }
      while ((static_cast<double>(teeth[k]) + 0.3) / kTeeth[k] <= turns) {
        const double at = (static_cast<double>(teeth[k]++) + 0.3) / kTeeth[k] / kSpeedHz * kTickHz;
        rig.board.line_change(k, Signal::kA, true, static_cast<std::uint64_t>(at + 0.5));
      }
    }
  }

  void step(std::uint64_t ticks) {
    for (std::size_t k = 0; k < kLines; ++k) {
      const double angle = 2.0 * kPi * (turns_at(ticks) + (k == 1 ? kDatumTurns : 0.0));
      const std::array<double, 4> in = {std::sin(angle), std::cos(angle), rig.hardware.codes[2 * k] / 32767.0,
                                        rig.hardware.codes[2 * k + 1] / 32767.0};
      for (std::size_t n = 0; n < 4; ++n) wheels[k].out[n] = wheels[k].filters[n].step(in[n]);
    }
  }
};

std::uint32_t word_of(double value) {
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(value * 8'388'607.0)) & 0xFFFFFF;
}

bool begin(Rig& rig) {
  Configuration configuration = test_configuration();
  configuration.references_on = 1;
  configuration.filter_order = 4;
  configuration.filter_corner_hz = 200;
  configuration.encoder = {{{96, kZeroWired}, {1000, kZeroWired}}};
  ReferenceSetup setup;
  setup.wheel[0] = {.on = 1, .line = 0};
  setup.wheel[1] = {.on = 1, .line = 1, .amplitude_per_mille = 500, .datum = 1 << 29};
  return rig.send(Request::kReferences, encode(setup)) && rig.begin(configuration);
}

// Degrees from the truth's to the loop-back's angle, both as they come out of the packet.
double lag_deg(const PacketScan& scan, std::size_t wheel) {
  const double sine = scan.counts[2 * wheel];
  const double cosine = scan.counts[2 * wheel + 1];
  const double loop_sine = scan.counts[kInputChannels + 2 * wheel];
  const double loop_cosine = scan.counts[kInputChannels + 2 * wheel + 1];
  return std::atan2(sine * loop_cosine - cosine * loop_sine, cosine * loop_cosine + sine * loop_sine) *
         180.0 / kPi;
}

}  // namespace

// The codes' quantum is 1 / 32767 of full scale: 0.002 degrees at 0.9, 0.0035 at 0.5, less what the filter
// smooths. The tracking loop, the ticks' rounding and the hold of 50 us, whose middle is asked for, add less
// than 0.001. The zero mark is stamped to the step of 10 us: up to 0.065 degrees at 18 Hz, averaged over
// eight marks; it is the same for both wheels.
BOARD_TEST(references_come_back_aligned_with_the_accelerations) {
  World world(200.0);
  REQUIRE(begin(world.rig));
  double largest_between = 0.0;
  double largest = 0.0;
  double size_0 = 0.0;
  double size_1 = 0.0;
  std::uint64_t checked = 0;
  for (std::uint64_t ticks = kStepTicks; ticks <= 3 * std::uint64_t{kTickHz} / 2; ticks += kStepTicks) {
    world.rig.hardware.now = ticks;
    world.pass_edges(ticks);
    if (ticks % kDacTicks == 0) world.rig.board.update_references(ticks + kDacTicks / 2 - kStepTicks / 2);
    world.step(ticks);
    if (ticks % kTicksPerScan != 0) continue;
    ScanWords words{};
    for (std::size_t k = 0; k < kLines; ++k)
      for (std::size_t n = 0; n < 2; ++n) {
        words[2 * k + n] = word_of(0.9 * world.wheels[k].out[n]);
        words[kInputChannels + 2 * k + n] = word_of(world.wheels[k].out[2 + n]);
      }
    world.rig.board.scan(words, 0, ticks);
    const auto packet = world.rig.packet();
    if (!packet || ticks < kTickHz) continue;
    CHECK_EQUAL(packet->header().flags & (kLocked0 | kLocked1), kLocked0 | kLocked1);
    for (std::size_t n = 0; n < packet->header().scans; ++n, ++checked) {
      const PacketScan scan = packet->scan(n);
      const double lag_0 = lag_deg(scan, 0);
      const double lag_1 = lag_deg(scan, 1);
      largest = std::max({largest, std::fabs(lag_0), std::fabs(lag_1)});
      largest_between = std::max(largest_between, std::fabs(lag_0 - lag_1));
      size_0 = std::max(size_0, scan.counts[12] / 8'388'607.0);
      size_1 = std::max(size_1, scan.counts[14] / 8'388'607.0);
    }
  }
  CHECK(checked > 4'900);
  CHECK_NEAR(largest, 0.0, 0.065);
  CHECK_NEAR(largest_between, 0.0, 0.01);
  // The filter's gain at 18 Hz is 1 to 1e-8.
  CHECK_NEAR(size_0, 0.9, 0.001);
  CHECK_NEAR(size_1, 0.5, 0.001);
}

BOARD_TEST(references_are_zero_until_the_angle_is_known) {
  World world(200.0);
  REQUIRE(begin(world.rig));
  world.rig.hardware.codes.fill(1);
  world.rig.board.update_references(1'000);
  for (const std::int16_t code : world.rig.hardware.codes) CHECK_EQUAL(code, 0);
}

}  // namespace roadbalance::board::test
