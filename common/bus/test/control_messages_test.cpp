#include "common/bus/control_messages.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "common/bus/results.hpp"
#include "common/test/bit_flips.hpp"

namespace roadbalance {
namespace {

using test::expect_every_bit_flip_refused;

Ack some_ack() {
  return {.node = 2,
          .epoch = -5,
          .incarnation = 1'700'000'000'000,
          .number = 7,
          .received = 100,
          .durable = 90,
          .credit = 2000,
          .missing = {{101, 103}, {110, 110}}};
}

TEST(Control, AnAckArrivesAsItWasSent) {
  const auto ack = decode_ack(encode(some_ack()));
  ASSERT_TRUE(ack);
  EXPECT_EQ(ack->node, 2);
  EXPECT_EQ(ack->epoch, -5);
  EXPECT_EQ(ack->incarnation, 1'700'000'000'000);
  EXPECT_EQ(ack->number, 7);
  EXPECT_EQ(ack->received, 100);
  EXPECT_EQ(ack->durable, 90);
  EXPECT_EQ(ack->credit, 2000);
  EXPECT_EQ(ack->missing, some_ack().missing);
}

TEST(Control, RefusesEverySingleBitFlip) {
  expect_every_bit_flip_refused(encode(some_ack()), decode_ack);
  expect_every_bit_flip_refused(encode(Heartbeat{.node = 1, .epoch = 3, .base = 5, .next = 9}),
                                decode_heartbeat);
  expect_every_bit_flip_refused(encode(Command{.node = 1, .request = 3, .incarnation = 5}), decode_command);
  expect_every_bit_flip_refused(encode(Reply{.node = 1, .epoch = 2, .request = 3, .sequence = 4}),
                                decode_reply);
}

TEST(Control, RefusesIndicesThatNoDriveReaches) {
  const auto beat = [](std::int64_t base, std::int64_t next, std::int64_t time_ns) {
    return decode_heartbeat(encode(Heartbeat{.node = 1, .base = base, .next = next, .time_ns = time_ns}));
  };
  EXPECT_TRUE(beat(kIndexLimit, kIndexLimit, kClockLimit_ns));
  EXPECT_FALSE(beat(kIndexLimit, kIndexLimit + 1, 0));
  EXPECT_FALSE(beat(1, std::numeric_limits<std::int64_t>::max(), 0));
  EXPECT_FALSE(beat(1, 1, kClockLimit_ns + 1));
  EXPECT_FALSE(beat(1, 1, std::numeric_limits<std::int64_t>::min()));
  EXPECT_FALSE(decode_reply(encode(Reply{.node = 1, .sequence = kIndexLimit + 1})));
  Ack ack = some_ack();
  ack.credit = kIndexLimit + 1;
  EXPECT_FALSE(decode_ack(encode(ack)));
  ack = some_ack();
  ack.missing = {{101, kIndexLimit + 1}};
  EXPECT_FALSE(decode_ack(encode(ack)));
  ack = some_ack();
  ack.incarnation = kIndexLimit + 1;
  EXPECT_FALSE(decode_ack(encode(ack)));
  EXPECT_FALSE(decode_heartbeat(encode(Heartbeat{.node = 1, .owner = kIndexLimit + 1})));
  EXPECT_FALSE(decode_command(encode(Command{.node = 1, .incarnation = kIndexLimit + 1})));
}

TEST(Control, RefusesNodesThatCannotBe) {
  for (const std::int32_t node : {-1, 0, kLastNode + 1})
    EXPECT_FALSE(decode_heartbeat(encode(Heartbeat{.node = node}))) << node;
  EXPECT_TRUE(decode_heartbeat(encode(Heartbeat{.node = kLastNode})));
}

TEST(Control, RefusesAnAckThatContradictsItself) {
  Ack ack = some_ack();
  ack.durable = ack.received + 1;  // durable is never ahead of received
  EXPECT_FALSE(decode_ack(encode(ack)));
  ack = some_ack();
  ack.missing = {{50, 60}};  // received already
  EXPECT_FALSE(decode_ack(encode(ack)));
  ack = some_ack();
  ack.missing = {{110, 120}, {115, 130}};
  EXPECT_FALSE(decode_ack(encode(ack)));
}

TEST(Control, AHeartbeatArrivesWithWhatItsDevicesCounted) {
  Heartbeat sent{.node = 1, .epoch = 3, .unreferenced_blocks = 4, .time_base = TimeBase::kShared};
  for (std::size_t k = 0; k < kDeviceCounters; ++k)
    sent.device_counts[k] = 100 + 7 * static_cast<std::int64_t>(k);
  const auto beat = decode_heartbeat(encode(sent));
  ASSERT_TRUE(beat);
  EXPECT_EQ(beat->device_counts, sent.device_counts);
  EXPECT_EQ(beat->unreferenced_blocks, 4);  // the fields on both sides of it
  EXPECT_EQ(beat->time_base, TimeBase::kShared);
  sent.device_counts.back() = -1;
  EXPECT_FALSE(decode_heartbeat(encode(sent)));
  sent.device_counts.back() = kIndexLimit + 1;
  EXPECT_FALSE(decode_heartbeat(encode(sent)));
}

TEST(Control, RefusesAHeartbeatWhoseRingIsInsideOut) {
  EXPECT_FALSE(decode_heartbeat(encode(Heartbeat{.node = 1, .base = 10, .next = 9})));
  EXPECT_FALSE(decode_heartbeat(encode(Heartbeat{.node = 1, .ring_used = 10, .ring_capacity = 9})));
}

TEST(Results, ABalanceArrivesAsItWasSent) {
  Balance sent{.wheel = 3, .time_ns = 5, .state = Unknown::kNone, .unbalance_g = 35.5, .angle_rad = 3.75};
  sent.covariance_g2 << 1, 2, 3, 4;
  sent.force_state = ForceState::kSeparated;
  sent.force_n = 25.0;
  sent.sigma_alone_g = 2.5;
  const auto balance = decode_balance(encode(sent));
  ASSERT_TRUE(balance);
  EXPECT_EQ(balance->wheel, 3);
  EXPECT_EQ(balance->unbalance_g, 35.5);
  EXPECT_EQ(balance->angle_rad, 3.75);
  EXPECT_EQ(balance->covariance_g2, sent.covariance_g2);
  EXPECT_EQ(balance->force_state, ForceState::kSeparated);
  EXPECT_EQ(balance->force_n, 25.0);
  EXPECT_EQ(balance->sigma_alone_g, 2.5);
  sent.force_state = static_cast<ForceState>(3);
  EXPECT_FALSE(decode_balance(encode(sent)));
  sent.force_state = ForceState::kNotJudged;
  sent.wheel = 4;
  EXPECT_FALSE(decode_balance(encode(sent)));
}

TEST(Results, ASpectrumArrivesWithAsManyBinsAsItHas) {
  SpectrumPart sent{.node = 1,
                    .channel = 15,
                    .part = 1,
                    .parts = 2,
                    .first_hz = 0.5,
                    .step_hz = 0.25,
                    .density = {1.5f, 2.5f, 3.5f}};
  const auto spectrum = decode_spectrum(encode(sent));
  ASSERT_TRUE(spectrum);
  EXPECT_EQ(spectrum->density, sent.density);
  EXPECT_EQ(spectrum->step_hz, 0.25);
  EXPECT_EQ(spectrum->state, SpectralState::kComputed);
}

TEST(Results, ASpectrumThatIsNotKnownHasAReasonAndNoBins) {
  SpectrumPart sent{.node = 1, .state = SpectralState::kTooMuch};
  ASSERT_TRUE(decode_spectrum(encode(sent)));
  EXPECT_EQ(decode_spectrum(encode(sent))->state, SpectralState::kTooMuch);
  sent.density = {1.5f};
  EXPECT_FALSE(decode_spectrum(encode(sent)));
  sent.density.clear();
  for (const int state : {-1, 5}) {
    sent.state = static_cast<SpectralState>(state);
    EXPECT_FALSE(decode_spectrum(encode(sent))) << state;
  }
}

TEST(Results, IdentificationAndLevelArriveAsTheyWereSent) {
  Identification sent{.sections = 4,
                      .state = Unknown::kNone,
                      .tyre_n_m = {1, 2, 3, 4},
                      .speed_class = {{.speed_m_s = 25, .seconds = 80}}};
  const auto identification = decode_identification(encode(sent));
  ASSERT_TRUE(identification);
  EXPECT_EQ(identification->tyre_n_m, sent.tyre_n_m);
  ASSERT_EQ(identification->speed_class.size(), 1u);
  EXPECT_EQ(identification->speed_class[0].seconds, 80);

  Level level{.node = 2, .seconds = 0.5};
  level.rms[15] = 0.7;
  level.dead = 0x8000;
  const auto got = decode_level(encode(level));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->rms, level.rms);
  EXPECT_EQ(got->dead, 0x8000u);
}

}  // namespace
}  // namespace roadbalance
