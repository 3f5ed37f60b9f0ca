#include "host/analysis/orders/order_vectors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "host/analysis/orders/test/sweep.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr int kRows = 32, kTurns = 8;

OrderVectors::Settings settings_of(std::vector<double> orders) {
  return {1, kRows, kTurns, std::move(orders), 200.0, 1.0, {}};
}

/// The wheel's turns from `first_turn` on.
TurnBlock block_of(const std::vector<test::OrderSignal>& signals, std::int64_t first_turn,
                   double rotation_hz = 15.5, std::int64_t run = 1) {
  TurnBlock block;
  block.first_turn = first_turn;
  block.run = run;
  block.rotation_hz = rotation_hz;
  block.values = Eigen::MatrixXd::Constant(kRows * kTurns, 1, 9.81);  // what does not turn must not matter
  for (Eigen::Index n = 0; n < block.values.rows(); ++n)
    for (const auto& signal : signals)
      block.values(n, 0) += signal.at(static_cast<double>(first_turn) + static_cast<double>(n) / kRows);
  return block;
}

TEST(OrderVectors, TellOrdersApartThatAreNoWholeNumbers) {
  const std::vector<test::OrderSignal> signals{
      {1.0, 1.0, 0.3}, {0.5, 0.5, -2.0}, {std::numbers::sqrt2, 1.4, 3.0}, {2.0, 2.0, 1.0}};
  OrderVectors vectors(settings_of({1.0, 0.5, std::numbers::sqrt2, 2.0}));
  for (std::int64_t turn = 3; turn < 80; turn += kTurns) vectors.add(block_of(signals, turn));
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const MeanVector vector = vectors.result(0, i).all;
    EXPECT_EQ(vector.count(), 10);
    const Complex expected = std::polar(signals[i].amplitude, signals[i].phase_rad);
    EXPECT_LT(std::abs(vector.mean() - expected), 1e-9) << signals[i].order;
  }
}

TEST(OrderVectors, FollowTheConvention) {
  // x = cos(alpha + 40 degrees) is at its highest 40 degrees of rotation before the reference point is up.
  OrderVectors vectors(settings_of({1.0}));
  vectors.add(block_of({{1.0, 1.0, 40.0 * std::numbers::pi / 180.0}}, 0));
  EXPECT_NEAR(std::arg(vectors.result(0, 0).all.mean()) * 180.0 / std::numbers::pi, 40.0, 1e-9);
}

TEST(OrderVectors, KeepSpeedsApart) {
  OrderVectors vectors(settings_of({1.0}));
  vectors.add(block_of({{1.0, 1.0}}, 0, 15.5));
  vectors.add(block_of({{1.0, 3.0}}, 8, 20.5));
  const auto result = vectors.result(0, 0);
  EXPECT_NEAR(result.all.mean().real(), 2.0, 1e-12);
  ASSERT_EQ(result.by_speed.size(), 2U);
  EXPECT_EQ(result.by_speed[1].from_hz, 20.0);
  EXPECT_NEAR(result.by_speed[0].vector.mean().real(), 1.0, 1e-12);
  EXPECT_NEAR(result.by_speed[1].vector.mean().real(), 3.0, 1e-12);
}

TEST(OrderVectors, OfNoWholeNumberHoldWithinARunOnly) {
  // After an interruption turns are counted anew, so half an order may come back with the other sign.
  OrderVectors vectors(settings_of({0.5, 1.0}));
  const test::OrderSignal half{0.5, 1.0, 0.4}, one{1.0, 1.0, 0.4};
  for (std::int64_t turn = 0; turn < 24; turn += kTurns) vectors.add(block_of({half, one}, turn, 15.5, 1));
  const test::OrderSignal turned{0.5, 1.0, 0.4 + std::numbers::pi};
  for (std::int64_t turn = 0; turn < 40; turn += kTurns) vectors.add(block_of({turned, one}, turn, 15.5, 2));
  for (std::int64_t turn = 0; turn < 16; turn += kTurns) vectors.add(block_of({half, one}, turn, 15.5, 3));
  EXPECT_EQ(vectors.result(0, 0).all.count(), 5) << "the longest run";
  EXPECT_LT(std::abs(vectors.result(0, 0).all.mean() - std::polar(1.0, turned.phase_rad)), 1e-9);
  EXPECT_EQ(vectors.result(0, 1).all.count(), 10) << "a whole order has the same phase in all";
  EXPECT_LT(std::abs(vectors.result(0, 1).all.mean() - std::polar(1.0, 0.4)), 1e-9);
}

TEST(OrderVectors, UndoWhatTheRecordingDid) {
  auto settings = settings_of({1.0, 2.0});
  const auto recorded = [](double order, double rotation_hz) {
    return std::polar(1.0 - 0.01 * order, -0.1 * order * rotation_hz);
  };
  settings.as_recorded = recorded;
  OrderVectors vectors(settings);
  const Complex first = 2.0 * recorded(1.0, 12.5), second = 3.0 * recorded(2.0, 12.5);
  vectors.add(block_of({{1.0, std::abs(first), std::arg(first)}, {2.0, std::abs(second), std::arg(second)}},
                       0, 12.5));
  EXPECT_LT(std::abs(vectors.result(0, 0).all.mean() - 2.0), 1e-9);
  EXPECT_LT(std::abs(vectors.result(0, 1).all.mean() - 3.0), 1e-9);
}

TEST(OrderVectors, LeaveOutWhatTheSamplesDoNotHold) {
  OrderVectors vectors(settings_of({1.0, 12.0}));
  TurnBlock block = block_of({{1.0, 1.0}}, 0, 20.0);  // 240 Hz
  vectors.add(block);
  EXPECT_EQ(vectors.result(0, 0).all.count(), 1);
  EXPECT_EQ(vectors.result(0, 1).all.count(), 0);
  block.overload = 1;
  vectors.add(block);
  EXPECT_EQ(vectors.result(0, 0).all.count(), 1);
}

TEST(OrderVectors, RefuseOrdersThatABlockCannotTellApart) {
  for (const std::vector<double>& orders : {std::vector{1.0, 1.1}, {0.1}, {16.0}, {-1.0}})
    EXPECT_THROW(OrderVectors{settings_of(orders)}, std::invalid_argument) << orders[0];
}

}  // namespace
}  // namespace roadbalance
