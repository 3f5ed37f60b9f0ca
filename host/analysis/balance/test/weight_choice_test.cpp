#include "host/analysis/balance/weight_choice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr double kTurn = 2.0 * std::numbers::pi;

constexpr WeightPlace kOuter{0.19, WeightKind::kClip, RimPlane::kOuter};
constexpr WeightPlace kInner{0.19, WeightKind::kClip, RimPlane::kInner};
constexpr WeightPlace kStuck{0.19, WeightKind::kAdhesive, RimPlane::kOuter};
constexpr WeightPlace kSmaller{0.16, WeightKind::kClip, RimPlane::kOuter};

/// The rule of the header, with its own numbers.
double cost_of(const std::vector<WheelWeight>& weights, const WeightStock& stock, Complex wanted,
               double deviation) {
  double cost = 0.0;
  for (const WheelWeight& weight : weights) {
    wanted -= weight.moment_g_m();
    const double elsewhere = weight.place == stock.place[0] ? 1.0 : 1.5;
    cost += elsewhere * std::max(0.1 * stock.step_g * stock.place[0].radius_m, 0.1 * deviation) +
            0.01 * weight.mass_g * weight.place.radius_m;
  }
  return cost + std::sqrt(std::norm(wanted) + deviation * deviation);
}

bool clear_of(const WheelWeight& weight, const std::vector<WheelWeight>& others, const WeightStock& stock) {
  return std::ranges::none_of(others, [&](const auto& other) { return lies_on(weight, other, stock); });
}

/// Every mass on every place at every one of so many angles.
std::vector<WheelWeight> all_single(const WeightStock& stock, int places) {
  std::vector<WheelWeight> all;
  for (const WeightPlace& place : stock.place)
    for (int k = 1; k * stock.step_g <= stock.heaviest_g; ++k)
      for (int p = 0; p < places; ++p) all.push_back({k * stock.step_g, kTurn * p / places, place});
  return all;
}

/// Least cost of none, one and two of them.
double least_of_all(const WeightStock& stock, int places, Complex wanted, double deviation,
                    const std::vector<WheelWeight>& staying) {
  std::vector<WheelWeight> free;
  for (const WheelWeight& weight : all_single(stock, places))
    if (clear_of(weight, staying, stock)) free.push_back(weight);
  double least = cost_of({}, stock, wanted, deviation);
  for (auto one = free.begin(); one != free.end(); ++one) {
    least = std::min(least, cost_of({*one}, stock, wanted, deviation));
    if (stock.most == 2)
      for (auto other = free.begin(); other <= one; ++other)  // alike they may be
        if (!lies_on(*one, *other, stock))
          least = std::min(least, cost_of({*one, *other}, stock, wanted, deviation));
  }
  return least;
}

struct Case {
  WeightStock stock;
  int places;
  Complex wanted;
  double deviation;
  std::vector<WheelWeight> staying;
};

Case random_case(std::mt19937& random) {
  const auto uniform = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  const auto one_of = [&](auto... values) {
    const std::array all{values...};
    return all[std::uniform_int_distribution<std::size_t>(0, all.size() - 1)(random)];
  };
  Case made;
  made.places = one_of(2, 5, 12, 24, 36);
  made.stock = {.step_g = 5.0,
                .heaviest_g = one_of(5.0, 15.0, 30.0),
                .most = one_of(1, 2, 2),
                .place = {kOuter},
                .raster_rad = kTurn / made.places,
                .length_m_per_g = one_of(0.0, 2.5e-3, 10e-3)};
  if (const int more = one_of(0, 0, 1, 2, 3); more > 0)
    made.stock.place.push_back(std::array{kInner, kStuck, kSmaller}[static_cast<std::size_t>(more - 1)]);
  made.wanted = std::polar(uniform(0.0, 50.0) * 0.19, uniform(-7.0, 7.0));
  made.deviation = one_of(0.0, 0.1, 1.0);
  for (int n = one_of(0, 0, 1, 3, 8); n > 0; --n)
    made.staying.push_back(
        {uniform(5.0, 40.0), uniform(0.0, kTurn), one_of(kOuter, kInner, kStuck, kSmaller)});
  return made;
}

// Nothing on the raster costs less than what the bounded search has found.
TEST(ChooseWeights, FindsOnARasterWhatTryingAllDoes) {
  std::mt19937 random(5);
  int pairs = 0, beside = 0;
  for (int k = 0; k < 600; ++k) {
    const auto [stock, places, wanted, deviation, staying] = random_case(random);
    const auto found = choose_weights(stock, wanted, deviation, staying);
    ASSERT_LE(found.size(), static_cast<std::size_t>(stock.most));
    for (const WheelWeight& weight : found) {
      EXPECT_TRUE(clear_of(weight, staying, stock)) << k;
      EXPECT_NEAR(std::remainder(weight.angle_rad, stock.raster_rad), 0.0, 1e-9) << k;
    }
    if (found.size() == 2) {
      EXPECT_FALSE(lies_on(found[0], found[1], stock)) << k;
    }
    EXPECT_NEAR(cost_of(found, stock, wanted, deviation),
                least_of_all(stock, places, wanted, deviation, staying), 1e-8)
        << k;
    pairs += found.size() == 2;
    beside += found.size() == 2 && !staying.empty();
  }
  EXPECT_GT(pairs, 100) << "the case that is tested";
  EXPECT_GT(beside, 30) << "the case that is tested";
}

// At free angles no raster, however fine, has a better choice, where none of the weights takes room.
TEST(ChooseWeights, FindsAtFreeAnglesWhatNoRasterBetters) {
  std::mt19937 random(6);
  for (int k = 0; k < 60; ++k) {
    Case made = random_case(random);
    made.stock.raster_rad = 0.0;
    made.stock.length_m_per_g = 0.0;
    const auto found = choose_weights(made.stock, made.wanted, made.deviation, {});
    EXPECT_LE(cost_of(found, made.stock, made.wanted, made.deviation),
              least_of_all(made.stock, 72, made.wanted, made.deviation, {}) + 1e-8)
        << k;
  }
}

// A full rim: eight weights of 60 g that take 150 mm each leave no place.
TEST(ChooseWeights, ChoosesNothingWhereThereIsNoRoom) {
  std::vector<WheelWeight> staying;
  for (int n = 0; n < 8; ++n) staying.push_back({60.0, kTurn * n / 8.0, kOuter});
  for (const double raster_rad : {0.0, kTurn / 360.0}) {
    const WeightStock stock{.place = {kOuter}, .raster_rad = raster_rad};
    EXPECT_TRUE(choose_weights(stock, {3.0, 4.0}, 0.1, staying).empty());
  }
}

}  // namespace
}  // namespace roadbalance
