#include "common/bus/compensation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/bus/other_wire.hpp"

namespace roadbalance {
namespace {

Compensation message() {
  Compensation sent{.wheel = 3, .time_ns = 123, .advice = Advice::kSteps, .radii = 2};
  sent.plan.step = {{WeightAction::kMove,
                     {20.0, 0.5, {0.19, WeightKind::kClip, RimPlane::kOuter}},
                     {20.0, 1.5, {0.16, WeightKind::kClip, RimPlane::kInner}}},
                    {WeightAction::kAdd, {5.0, 2.5, {0.17, WeightKind::kAdhesive, RimPlane::kInner}}, {}},
                    {WeightAction::kKeep, {15.0, 3.5, {.radius_m = 0.19}}, {}}};
  sent.plan.applied_g_m = {1.25, -2.5};
  sent.verdict = {.residual_g = 1.5,
                  .shop_g = 7.0,
                  .permissible_g = 32.0,
                  .permissible_grade_mm_s = 40.0,
                  .grade_mm_s = 2.0,
                  .by_rotor = true,
                  .force_left_share = 0.25,
                  .incurable = "speed² dominates"};
  sent.wanted_sigma_g = 2.0;
  sent.seconds_wanted = 42.0;
  sent.seat_now_m_s2 = 0.05;
  sent.seat_left_m_s2 = 0.01;
  return sent;
}

TEST(Compensation, ComesBackAsItWasSent) {
  const auto bytes = encode(message());
  EXPECT_LT(bytes.size(), 1400U) << "one datagram";
  const auto got = decode_compensation(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->wheel, 3);
  EXPECT_EQ(got->time_ns, 123);
  EXPECT_EQ(got->advice, Advice::kSteps);
  EXPECT_EQ(got->radii, 2);
  ASSERT_EQ(got->plan.step.size(), 3U);
  EXPECT_EQ(got->plan.step[0].action, WeightAction::kMove);
  EXPECT_EQ(got->plan.step[0].weight.mass_g, 20.0);
  EXPECT_EQ(got->plan.step[0].weight.angle_rad, 0.5);
  EXPECT_EQ(got->plan.step[0].weight.place, (WeightPlace{0.19, WeightKind::kClip, RimPlane::kOuter}));
  EXPECT_EQ(got->plan.step[0].from.angle_rad, 1.5);
  EXPECT_EQ(got->plan.step[0].from.place, (WeightPlace{0.16, WeightKind::kClip, RimPlane::kInner}));
  EXPECT_EQ(got->plan.step[1].action, WeightAction::kAdd);
  EXPECT_EQ(got->plan.step[1].weight.place, (WeightPlace{0.17, WeightKind::kAdhesive, RimPlane::kInner}));
  EXPECT_EQ(got->plan.step[2].weight.place, WeightPlace{.radius_m = 0.19});
  EXPECT_EQ(got->plan.applied_g_m, std::complex<double>(1.25, -2.5));
  EXPECT_EQ(got->verdict.residual_g, 1.5);
  EXPECT_EQ(got->verdict.shop_g, 7.0);
  EXPECT_EQ(got->verdict.permissible_g, 32.0);
  EXPECT_EQ(got->verdict.permissible_grade_mm_s, 40.0);
  EXPECT_EQ(got->verdict.grade_mm_s, 2.0);
  EXPECT_TRUE(got->verdict.by_rotor);
  EXPECT_EQ(got->verdict.force_left_share, 0.25);
  EXPECT_EQ(got->verdict.incurable, "speed² dominates");
  EXPECT_EQ(got->wanted_sigma_g, 2.0);
  EXPECT_EQ(got->seconds_wanted, 42.0);
  EXPECT_EQ(got->seat_now_m_s2, 0.05);
  EXPECT_EQ(got->seat_left_m_s2, 0.01);
}

TEST(Compensation, RefusesWhatCannotBe) {
  const auto taken = [](auto spoil) {
    Compensation sent = message();
    spoil(sent);
    return decode_compensation(encode(sent)).has_value();
  };
  for (const std::int32_t wheel : {-1, 4, 5})
    EXPECT_FALSE(taken([&](Compensation& sent) { sent.wheel = wheel; })) << wheel;
  for (const std::int32_t advice : {-1, 4})
    EXPECT_FALSE(taken([&](Compensation& sent) { sent.advice = static_cast<Advice>(advice); })) << advice;
  for (const std::int32_t action : {-1, 4})
    EXPECT_FALSE(taken([&](Compensation& sent) {
      sent.plan.step[1].action = static_cast<WeightAction>(action);
    })) << action;
  for (const std::int32_t beyond : {-1, 3}) {
    EXPECT_FALSE(taken([&](Compensation& sent) {
      sent.plan.step[2].weight.place.kind = static_cast<WeightKind>(beyond);
    })) << beyond;
    EXPECT_FALSE(taken([&](Compensation& sent) {
      sent.plan.step[2].weight.place.plane = static_cast<RimPlane>(beyond);
    })) << beyond;
    EXPECT_FALSE(taken([&](Compensation& sent) {
      sent.plan.step[0].from.place.plane = static_cast<RimPlane>(beyond);
    })) << beyond;
  }
  for (const std::int32_t wheel : {0, 3})
    EXPECT_TRUE(taken([&](Compensation& sent) { sent.wheel = wheel; })) << wheel;
}

/// Where a number stands in the encoded message: the one place in which two messages differ.
std::size_t place_of(const Compensation& one, const Compensation& other) {
  const auto a = encode(one), b = encode(other);
  for (std::size_t k = 0; k + 4 <= a.size(); k += 4)
    if (!std::equal(a.begin() + static_cast<std::ptrdiff_t>(k),
                    a.begin() + static_cast<std::ptrdiff_t>(k + 4),
                    b.begin() + static_cast<std::ptrdiff_t>(k)))
      return k;
  return a.size();
}

/// Network order, as LCM writes it.
void put(std::vector<std::uint8_t>& bytes, std::size_t at, std::int32_t value) {
  for (std::size_t k = 0; k < 4; ++k)
    bytes.at(at + k) = static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> (24 - 8 * k));
}

TEST(Compensation, RefusesCountsBeyondItsRoom) {
  Compensation full = message();
  full.verdict.incurable.assign(kMostReasonBytes, 'x');
  Compensation empty = full, shorter = full;
  empty.plan.step.clear();
  shorter.verdict.incurable.pop_back();
  const std::size_t steps = place_of(full, empty), size = place_of(full, shorter);
  for (const auto& [at, most] : {std::pair{steps, 10}, {size, 240}}) {
    auto bytes = encode(full);
    put(bytes, at, most);
    EXPECT_TRUE(decode_compensation(bytes)) << at;
    for (const std::int32_t beyond : {most + 1, -1, INT32_MIN, INT32_MAX}) {
      put(bytes, at, beyond);
      EXPECT_FALSE(decode_compensation(bytes)) << at << " " << beyond;
    }
  }
}

/// It goes to terminals and into JSON.
TEST(Compensation, RefusesAReasonThatIsNoPlainText) {
  Compensation sent = message();
  sent.verdict.incurable = "a reason";
  const auto good = encode(sent);
  const auto begin = std::ranges::search(good, sent.verdict.incurable).begin() - good.begin();
  for (const int byte : {0x00, 0x0A, 0x1B, 0x7F, 0x80, 0xFF}) {
    auto bytes = good;
    bytes.at(static_cast<std::size_t>(begin)) = static_cast<std::uint8_t>(byte);
    EXPECT_FALSE(decode_compensation(bytes)) << byte;
  }
}

/// It may quote the vehicle file.
TEST(Compensation, AReasonIsMadePlainAndCutWhereItIsSent) {
  Compensation sent = message();
  sent.verdict.incurable = "\033[2J " + std::string(kMostReasonBytes, 'x');
  const auto got = decode_compensation(encode(sent));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->verdict.incurable,
            (" [2J " + std::string(kMostReasonBytes, 'x')).substr(0, kMostReasonBytes));
}

TEST(Compensation, OfAnotherVersionIsNoticed) {
  auto bytes = encode(message());
  bytes[3] ^= 1U;
  OtherWire wire;
  wire.take(kCompensationChannel, bytes);
  wire.take(kCompensationChannel, bytes);
  EXPECT_EQ(wire.sentences().size(), 1U);
}

}  // namespace
}  // namespace roadbalance
