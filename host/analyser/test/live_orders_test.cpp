#include "host/analyser/live_orders.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/analysis/orders/test/synthetic_rotor.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;

TEST(LiveOrders, ReportEveryWheelInEveryNodeThatIsThere) {
  const VehicleConfig vehicle = test::rotor_vehicle(1.0, {2});
  const auto left = [](double t) { return 2 * pi * 12.0 * t + 0.3; };
  const auto right = [](double t) { return 2 * pi * 13.5 * t; };
  const std::complex<double> a = std::polar(1.5, 0.7), far = std::polar(0.4, -2.0);
  const test::SyntheticDrive drive{.left_rad = left,
                                   .right_rad = right,
                                   .shaft_rad = left,
                                   .vector = {a, 0.0, far},
                                   .noise = 0.1,
                                   .seconds = 30.0,
                                   .silent_from_s = 10.0,
                                   .silent_to_s = 12.0};
  LiveOrders orders(vehicle);
  EXPECT_TRUE(orders.reports().empty()) << "nothing came";
  drive.seal_into([&](const SealedBlock& block) { orders.consume(block); });
  const auto reports = orders.reports();
  ASSERT_EQ(reports.size(), 4U) << "two wheels, two nodes";
  for (const OrderReport& report : reports) {
    const bool is_left = report.wheel == 2, is_near = report.node == 3;
    EXPECT_NEAR(report.seconds, 30.0, 0.1);
    EXPECT_NEAR(report.no_angle_s, is_left ? 2.0 : 0.0, 0.05);
    EXPECT_GT(report.time_ns, 29'000'000'000);
    const OrderReport::Vector& first = report.order[0][0];
    EXPECT_GT(first.blocks, 35);
    const std::complex<double> expected = is_left ? (is_near ? a : far) : 0.0;
    EXPECT_LT(std::abs(first.value - expected), 1.5 * first.amplitude_95 + 2e-3 * std::abs(expected));
    EXPECT_EQ(std::isnan(first.phase_95_rad), !is_left) << "what does not turn with it has no phase";
    EXPECT_EQ(report.order[1][0].blocks, first.blocks);
    EXPECT_EQ(report.order[0][5].blocks, 0) << "there is no such channel";
  }
}

TEST(LiveOrders, OfANodeThatStaysAwayTheOthersGoOn) {
  const VehicleConfig vehicle = test::rotor_vehicle(1.0, {2});
  const auto wheel = [](double t) { return 2 * pi * 12.0 * t; };
  const test::SyntheticDrive drive{
      .left_rad = wheel, .right_rad = wheel, .shaft_rad = wheel, .vector = {1.0, 0.0, 0.5}, .seconds = 20.0};
  LiveOrders orders(vehicle);
  drive.seal_into([&](const SealedBlock& block) {
    if (block.header.node == 3) orders.consume(block);
  });
  const auto reports = orders.reports();
  ASSERT_EQ(reports.size(), 2U);
  for (const OrderReport& report : reports) EXPECT_EQ(report.node, 3);
}

}  // namespace
}  // namespace roadbalance
