#include "firmware/reference.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>

#include "common/types/angle_sigma.hpp"
#include "firmware/test/butterworth.hpp"
#include "firmware/test/vehicle.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr double kDegree = pi / 180.0;
constexpr double kRate_hz = 2000.0;

/// An analogue Butterworth low-pass, integrated by Runge-Kutta in steps of a hundredth of a scan: independent
/// of the product's discretisation and of its state-space form (cascade of its poles' second-order sections).
class AnalogueFilter {
 public:
  AnalogueFilter(int order, double cutoff_hz) : corner_(2 * pi * cutoff_hz), sections_(order / 2) {
    for (int k = 0; k < order / 2; ++k) damping_[k] = std::sin(pi * (2 * k + 1) / (2.0 * order));
  }
  /// Output after a step with the input given at its begin, middle and end.
  double step(double u0, double u1, double u2, double h) {
    State k1 = rate(x_, u0), k2 = rate(moved(x_, k1, h / 2), u1), k3 = rate(moved(x_, k2, h / 2), u1),
          k4 = rate(moved(x_, k3, h), u2);
    for (int i = 0; i < 2 * sections_; ++i) x_[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    return x_[2 * (sections_ - 1)];
  }

 private:
  using State = std::array<double, 12>;
  State rate(const State& x, double u) const {
    State d{};
    for (int k = 0; k < sections_; ++k) {
      const double in = k == 0 ? u : x[2 * (k - 1)];
      d[2 * k] = corner_ * x[2 * k + 1];
      d[2 * k + 1] = corner_ * (in - x[2 * k] - 2 * damping_[k] * x[2 * k + 1]);
    }
    return d;
  }
  State moved(const State& x, const State& d, double h) const {
    State y = x;
    for (int i = 0; i < 2 * sections_; ++i) y[i] += h * d[i];
    return y;
  }
  double corner_;
  int sections_;
  std::array<double, 6> damping_{};
  State x_{};
};

/// Angle between the reference and what sin and cos of the true angle are after the analogue filter, mean
/// over `seconds` after a settled start.
double phase_difference_deg(std::function<double(double)> angle, double seconds) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  Reference reference(vehicle, vehicle.node[0]);
  // Many fine teeth and no errors, so that the filter and not the encoder is measured.
  const sim::PulseTrain train{.angle_rad = angle};
  const auto edges = train.edges(0.0, seconds + 0.1);
  AnalogueFilter cosine(vehicle.filter.order, vehicle.filter.cutoff_hz), sine = cosine;
  std::complex<double> sum = 0.0;
  std::size_t edge = 0;
  std::array<std::array<std::int32_t, kChannels>, kScansPerBlock> rows{};
  constexpr int kFine = 20;
  const double h = 1.0 / (kRate_hz * kFine);
  double last_cosine = 0, last_sine = 0;
  std::int64_t fine = 0;
  for (std::int64_t block = 0; static_cast<double>(block) * kScansPerBlock / kRate_hz < seconds; ++block) {
    const std::int64_t first = block * kScansPerBlock;
    const auto time = [](std::int64_t scan) { return node_time_from_ns(scan * 500'000); };
    while (edge < edges.size() && edges[edge].time <= reference.complete_at(time(first + kScansPerBlock - 1)))
      reference.add(edges[edge++]);
    reference.locate(time(first), kScansPerBlock);
    const auto quality = reference.fill(rows, block == 0);
    for (int row = 0; row < kScansPerBlock; ++row) {
      for (; fine < (first + row) * kFine; ++fine) {
        const double t = static_cast<double>(fine) * h;
        last_cosine = cosine.step(std::cos(angle(t)), std::cos(angle(t + h / 2)), std::cos(angle(t + h)), h);
        last_sine = sine.step(std::sin(angle(t)), std::sin(angle(t + h / 2)), std::sin(angle(t + h)), h);
      }
      if (quality & kQualityNoReference0) continue;
      const auto& counts = rows[static_cast<std::size_t>(row)];
      const std::complex<double> ours(counts[kAccelerations + 1], counts[kAccelerations]);
      sum += ours / std::complex<double>(last_cosine, last_sine);
    }
  }
  EXPECT_GT(std::abs(sum), 0.0);
  return std::arg(sum) / kDegree;
}

TEST(Reference, HasThePhaseOfAnAccelerationBehindTheAnalogueFilter) {
  // Without the filter's copy this would be 20 degrees (18 Hz, order 6, 200 Hz: ENCODER, table of causes).
  EXPECT_NEAR(phase_difference_deg([](double t) { return 2 * pi * 18.0 * t; }, 3.0), 0.0, 0.002);
}

TEST(Reference, HasThePhaseOfEveryFilterAtEverySpeed) {
  for (const int order : {4, 5, 6, 7, 8})
    for (const double cutoff_hz : {100.0, 200.0, 400.0})
      for (const double hz : {5.0, 18.0, 25.0}) {
        auto vehicle = test::one_node_vehicle(kRate_hz);
        vehicle.filter = {order, cutoff_hz};
        Reference reference(vehicle, vehicle.node[0]);
        const auto angle = [hz](double t) { return 2 * pi * hz * t; };
        for (const Edge& edge : sim::PulseTrain{.angle_rad = angle}.edges(0.0, 2.0)) reference.add(edge);
        std::array<std::array<std::int32_t, kChannels>, kScansPerBlock> rows{};
        std::complex<double> sum = 0.0;
        for (int block = 150; block < 180; ++block) {
          static_cast<void>(reference.locate(node_time_from_ns(block * 10'000'000), kScansPerBlock));
          const auto quality = reference.fill(rows, block == 150);
          for (int row = 0; row < kScansPerBlock && !(quality & kQualityNoReference0); ++row) {
            const auto& counts = rows[static_cast<std::size_t>(row)];
            sum += std::complex<double>(counts[kAccelerations + 1], counts[kAccelerations]) *
                   std::polar(1.0, -angle((block * kScansPerBlock + row) / kRate_hz));
          }
        }
        EXPECT_NEAR(std::arg(sum / test::response(vehicle.filter, hz)) / kDegree, 0.0, 0.01)
            << order << " " << cutoff_hz << " " << hz;
      }
}

TEST(Reference, HasItAlsoWhileTheSpeedDrifts) {
  // 5 km/h per minute are 0.0125 turns/s^2; here ten times that.
  EXPECT_NEAR(phase_difference_deg([](double t) { return 2 * pi * (17.0 * t + 0.0625 * t * t); }, 4.0), 0.0,
              0.002);
}

TEST(Reference, HasTheGainOfTheFilter) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  Reference reference(vehicle, vehicle.node[0]);
  const sim::PulseTrain train{.angle_rad = [](double t) { return 2 * pi * 18.0 * t; }};
  for (const Edge& edge : train.edges(0.0, 1.2)) reference.add(edge);
  std::array<std::array<std::int32_t, kChannels>, kScansPerBlock> rows{};
  for (int block = 90; block < 110; ++block) {
    ASSERT_FALSE(
        reference.locate(node_time_from_ns(block * 10'000'000), kScansPerBlock));  // line 1 has no edges
    reference.fill(rows, block == 90);
  }
  const auto& row = rows.back();
  const double amplitude = std::hypot(row[kAccelerations], row[kAccelerations + 1]) / kFullScaleCounts;
  const double expected = 1.0 / std::sqrt(1.0 + std::pow(18.0 / 200.0, 12.0));
  EXPECT_NEAR(amplitude, expected, 1e-4);  // linear between steps of 0.25 ms: (w h)^2 / 12 = 7e-5
}

TEST(Reference, TellsHowWellItsAnglesAreKnown) {
  for (const double jitter_s : {10e-6, 100e-6}) {
    auto vehicle = test::one_node_vehicle(kRate_hz);
    vehicle.wheel[1].node.clear();
    Reference reference(vehicle, vehicle.node[0]);
    const auto angle = [](double t) { return 2 * pi * 18.0 * t; };
    const sim::PulseTrain train{
        .angle_rad = angle, .pitch_error_rad = sim::pitch_errors(96, 0.3 * kDegree, 3), .jitter_s = jitter_s};
    const auto edges = train.edges(0.0, 40.2);
    std::array<std::array<std::int32_t, kChannels>, kScansPerBlock> rows{};
    std::size_t edge = 0;
    double square = 0.0, told = 0.0;
    int judged = 0;
    for (int block = 0; block < 4000; ++block) {
      const NodeTime first = node_time_from_ns(block * 10'000'000LL);
      const NodeTime last = first + NodeClock::duration(9'500'000);
      for (; edge < edges.size() && edges[edge].time <= reference.complete_at(last); ++edge)
        reference.add(edges[edge]);
      static_cast<void>(reference.locate(first, kScansPerBlock));
      const auto quality = reference.fill(rows, block == 0);
      EXPECT_FALSE(angle_sigma_rad(quality, 1)) << "no encoder is there";
      if (block < 2000) continue;  // the ring is learned
      ASSERT_TRUE(angle_sigma_rad(quality, 0));
      told = std::max(told, *angle_sigma_rad(quality, 0) / kDegree);
      const double t = block * 0.01;
      const std::complex<double> ours(rows[0][kAccelerations + 1], rows[0][kAccelerations]);
      const double off =
          std::arg(ours / test::response(vehicle.filter, 18.0) * std::polar(1.0, -angle(t))) / kDegree;
      square += off * off;
      ++judged;
    }
    const double rms = std::sqrt(square / judged);
    std::printf("%3.0f us: %.4f degrees rms, %.4f told\n", 1e6 * jitter_s, rms, told);
    // It is given in half octaves, rounded up, and bounds a bias of the window that a steady wheel has not.
    EXPECT_GT(told, 0.8 * rms);
    EXPECT_LT(told, 3.0 * rms);
  }
}

TEST(Reference, IsFlaggedUntilTheFilterHasSettledAndALineWithoutEncoderAlways) {
  auto vehicle = test::one_node_vehicle(kRate_hz);
  vehicle.wheel[1].node.clear();
  Reference reference(vehicle, vehicle.node[0]);
  const sim::PulseTrain train{.angle_rad = [](double t) { return 2 * pi * 18.0 * t; }};
  for (const Edge& edge : train.edges(0.0, 1.2)) reference.add(edge);
  std::array<std::array<std::int32_t, kChannels>, kScansPerBlock> rows{};
  int flagged = 0;
  for (int block = 20; block < 40; ++block) {
    ASSERT_TRUE(reference.locate(node_time_from_ns(block * 10'000'000), kScansPerBlock));
    const auto quality = reference.fill(rows, block == 20);
    EXPECT_TRUE(quality & kQualityNoReference1);
    EXPECT_EQ(rows[0][kAccelerations + 2], 0);
    if (quality & kQualityNoReference0) {
      EXPECT_EQ(flagged, block - 20);  // at the beginning only
      ++flagged;
    }
  }
  // exp(-2 pi 200 sin(15 deg) t) = 1e-5 at 35.4 ms, in blocks of 10 ms.
  EXPECT_EQ(flagged, 4);
}

}  // namespace
}  // namespace roadbalance
