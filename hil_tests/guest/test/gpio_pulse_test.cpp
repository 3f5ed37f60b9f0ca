#include <gpiod.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <system_error>
#include <thread>

#include "hil_tests/guest/pulse_chip.hpp"
#include "hil_tests/guest/ring_program.hpp"

namespace roadbalance {
namespace {

using test::kLead_ns;
using test::PulseChip;
using test::pulses;

constexpr std::int64_t kTolerance_ns = 1000;
constexpr std::int64_t kLost_ns = 25'000;  // shorter than any time between edges here
constexpr std::size_t kMostEdges = 100'000;

struct Edge {
  std::int64_t t_ns;
  bool rising;
};

/// Reads the edges of one line by libgpiod's first interface, as a thread of real-time priority.
class EdgeReader {
 public:
  EdgeReader(unsigned line, bool both) : chip_(gpiod_chip_open_by_name(PulseChip::name().c_str())) {
    if (!chip_) throw std::system_error(errno, std::generic_category(), "open chip");
    line_ = gpiod_chip_get_line(chip_, line);
    const int failed = both ? gpiod_line_request_both_edges_events(line_, "test")
                            : gpiod_line_request_rising_edge_events(line_, "test");
    if (failed) throw std::system_error(errno, std::generic_category(), "request events");
    // Sixteen edges fit the kernel's queue: at 20 kHz there is no time for new pages of memory.
    edges_.resize(kMostEdges);
    edges_.clear();
    thread_ = std::jthread([this](const std::stop_token& stop) { collect(stop); });
    const sched_param priority{50};
    if (::pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority) != 0)
      throw std::runtime_error("no real-time priority");
  }
  ~EdgeReader() {
    thread_ = {};
    gpiod_chip_close(chip_);
  }
  EdgeReader(const EdgeReader&) = delete;
  EdgeReader& operator=(const EdgeReader&) = delete;

  /// All there were; nothing is read any more.
  const std::vector<Edge>& edges() {
    thread_ = {};
    return edges_;
  }

 private:
  void collect(const std::stop_token& stop) {
    // After the request to stop it reads until no edge is left.
    const timespec patience{0, 10'000'000};
    for (int ready = 0; (ready = gpiod_line_event_wait(line_, &patience)) >= 0;) {
      if (ready == 0 && stop.stop_requested()) return;
      if (ready == 0) continue;
      std::array<gpiod_line_event, 16> event;
      const int count = gpiod_line_event_read_multiple(line_, event.data(), event.size());
      if (count < 0) return;
      for (int k = 0; k < count; ++k) {
        const auto& [stamp, type] = event[static_cast<std::size_t>(k)];
        edges_.push_back({stamp.tv_sec * std::int64_t{1'000'000'000} + stamp.tv_nsec,
                          type == GPIOD_LINE_EVENT_RISING_EDGE});
      }
    }
  }

  gpiod_chip* chip_;
  gpiod_line* line_ = nullptr;
  std::vector<Edge> edges_;
  std::jthread thread_;
};

/// Each true edge was seen once, in order, with a stamp near the truth.
void expect_seen(const std::vector<Edge>& seen, const std::vector<gpio_pulse_step>& truth, bool both) {
  std::int64_t worst_ns = 0;
  std::size_t k = 0;
  for (const auto& step : truth) {
    if (!both && !step.value) continue;
    ASSERT_LT(k, seen.size()) << "an edge was lost";
    const std::int64_t error_ns = seen[k].t_ns - static_cast<std::int64_t>(step.t_ns);
    ASSERT_LT(std::abs(error_ns), kLost_ns) << "edge " << k << " was lost; seen " << seen.size();
    ASSERT_EQ(seen[k].rising, step.value == 1) << "edge " << k;
    worst_ns = std::max(worst_ns, std::abs(error_ns));
    ++k;
  }
  EXPECT_EQ(k, seen.size());
  EXPECT_LE(worst_ns, kTolerance_ns);
  std::printf("%zu edges, worst stamp %lld ns from the truth\n", seen.size(),
              static_cast<long long>(worst_ns));
}

TEST(GpioPulse, TwentyThousandRisingEdgesASecondAllArriveWithTrueStamps) {
  PulseChip chip;
  EdgeReader reader(3, false);
  chip.play(pulses(3, PulseChip::now_ns() + kLead_ns, 50'000, 20'000));
  const auto truth = chip.played();
  ASSERT_EQ(truth.size(), 40'000u);
  expect_seen(reader.edges(), truth, false);
}

TEST(GpioPulse, BothEdgesOfTenKilohertzAllArriveInTheirDirection) {
  PulseChip chip;
  EdgeReader reader(31, true);
  chip.play(pulses(31, PulseChip::now_ns() + kLead_ns, 100'000, 5000));
  const auto truth = chip.played();
  expect_seen(reader.edges(), truth, true);
}

// A car has four ABS rings; steps of several lines are one program.
TEST(GpioPulse, LinesAreIndependent) {
  PulseChip chip;
  EdgeReader first(0, false), second(1, false);
  const std::int64_t begin_ns = PulseChip::now_ns() + kLead_ns;
  auto steps = pulses(0, begin_ns, 500'000, 1000);
  for (const auto& step : pulses(1, begin_ns + 7'000, 333'000, 1500)) steps.push_back(step);
  std::ranges::stable_sort(steps, {}, &gpio_pulse_step::t_ns);
  chip.play(steps);
  const auto truth = chip.played();
  for (const unsigned line : {0u, 1u}) {
    auto its = truth;
    std::erase_if(its, [line](const gpio_pulse_step& step) { return step.line != line; });
    expect_seen(line == 0 ? first.edges() : second.edges(), its, false);
  }
}

TEST(GpioPulse, WritesWaitForRoomAndNothingIsForgotten) {
  PulseChip chip;
  constexpr std::size_t kSteps = GPIO_PULSE_QUEUE + 50'000;
  const std::int64_t begin_ns = PulseChip::now_ns();
  std::jthread writer([&] {
    for (std::size_t done = 0; done < kSteps; done += 10'000)
      chip.play(pulses(9, begin_ns + static_cast<std::int64_t>(done) * 1000, 2000, 5000));
  });
  std::size_t read = 0;
  std::uint64_t last_ns = 0;
  while (read < kSteps)
    for (const auto& step : chip.played()) {
      ASSERT_EQ(step.value, read++ % 2 == 0 ? 1u : 0u);
      ASSERT_GE(step.t_ns, last_ns);
      last_ns = step.t_ns;
    }
}

TEST(GpioPulse, BadProgramsAreRefused) {
  PulseChip chip;
  const auto refusal = [&](std::vector<gpio_pulse_step> steps) {
    try {
      chip.play(steps);
    } catch (const std::system_error& error) {
      return error.code().value();
    }
    return 0;
  };
  EXPECT_EQ(refusal({{1, GPIO_PULSE_LINES, 0}}), EINVAL);
  EXPECT_EQ(refusal({{1, 0, 2}}), EINVAL);
  EXPECT_EQ(refusal({{2, 0, 0}, {1, 0, 0}}), EINVAL);
  EXPECT_THROW(PulseChip(), std::system_error) << "two players at once";
  // Played long ago, never read: waiting would be for ever.
  EXPECT_EQ(refusal(pulses(0, 0, 2, GPIO_PULSE_QUEUE / 2 + 1)), ENOBUFS);
}

TEST(GpioPulse, AnUnpluggedChipIsGoneAndComesBackWithItsLevels) {
  PulseChip chip;
  chip.set(5, false);
  gpiod_chip* device = gpiod_chip_open_by_name(PulseChip::name().c_str());
  ASSERT_TRUE(device);
  gpiod_line* line = gpiod_chip_get_line(device, 5);
  ASSERT_EQ(gpiod_line_request_input(line, "test"), 0);
  EXPECT_EQ(gpiod_line_get_value(line), 0);

  PulseChip::unplug();
  EXPECT_THROW(PulseChip::name(), std::runtime_error);
  EXPECT_EQ(gpiod_line_get_value(line), -1);
  gpiod_chip_close(device);
  chip.set(5, true);
  PulseChip::plug();

  device = gpiod_chip_open_by_name(PulseChip::name().c_str());
  ASSERT_TRUE(device);
  line = gpiod_chip_get_line(device, 5);
  ASSERT_EQ(gpiod_line_request_input(line, "test"), 0);
  EXPECT_EQ(gpiod_line_get_value(line), 1);
  gpiod_chip_close(device);
}

}  // namespace
}  // namespace roadbalance
