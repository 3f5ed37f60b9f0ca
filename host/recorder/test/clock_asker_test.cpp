#include "host/recorder/clock_asker.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr UdpAddress kThere{0x0A000002, 4000};
const MachineTime kBegin = machine_time_from_ns(5'000'000'000);

/// A node whose clock is 3 s ahead; each way takes 100 us.
struct Node {
  UdpAddress address = kThere;
  bool answers = true, follows_up = true;
  std::int64_t ahead_ns = 3'000'000'000;
  int asked = 0;
};

/// Lets time pass in steps of 5 ms, with heartbeats every 100 ms.
class Exchanging {
 public:
  void run(milliseconds time, bool alive = true) {
    for (const MachineTime end = now + time; now < end; now += milliseconds(5)) {
      if (alive && (now - kBegin).count() % 100'000'000 == 0)
        asker.heard({.node = 2, .epoch = 9, .address = node.address}, now);
      for (const auto& question : asker.due(now)) answer(question);
      for (const auto& e : asker.exchanges(now)) exchanges.push_back(e);
      for (const auto& f : asker.fits(now)) fits.push_back(f);
    }
  }

  ClockAsker asker;
  Node node;
  MachineTime now = kBegin;
  std::vector<ClockExchange> exchanges;
  std::vector<ClockFit> fits;

 private:
  void answer(const ClockAsker::Question& question) {
    ++node.asked;
    EXPECT_EQ(question.to, node.address);
    asker.sent(question, {now, true});
    if (!node.answers) return;
    ClockDatagram datagram = question.datagram;
    datagram.kind = ClockDatagramKind::kAnswer;
    datagram.received_ns = to_ns(now) + 100'000 + node.ahead_ns;
    datagram.answered_ns = datagram.received_ns;
    datagram.received_by_kernel = true;
    asker.take(datagram, node.address, {now + std::chrono::microseconds(250), true});
    if (!node.follows_up) return;
    datagram.kind = ClockDatagramKind::kFollowUp;
    datagram.answered_ns += 50'000;
    datagram.answered_by_kernel = true;
    asker.take(datagram, node.address, {now + std::chrono::microseconds(300), true});
  }
};

TEST(ClockAsker, AsksInABurstAndThenEightTimesASecond) {
  Exchanging x;
  x.run(milliseconds(300));
  EXPECT_EQ(x.node.asked, 15);
  x.run(seconds(10));
  EXPECT_NEAR(x.node.asked, 15 + 80, 2);
  EXPECT_EQ(std::ssize(x.exchanges), x.node.asked);
}

TEST(ClockAsker, AnExchangeHasTheFourInstantsAndTheFollowUpsStamp) {
  Exchanging x;
  x.run(milliseconds(5));
  ASSERT_EQ(x.exchanges.size(), 1U);
  const ClockExchange& e = x.exchanges[0];
  EXPECT_EQ(e.asked_ns, to_ns(kBegin));
  EXPECT_EQ(e.received_ns, to_ns(kBegin) + 3'000'100'000);
  EXPECT_EQ(e.answered_ns, to_ns(kBegin) + 3'000'150'000);
  EXPECT_EQ(e.heard_ns, to_ns(kBegin) + 250'000);
  EXPECT_EQ(e.kernel_stamps, 15U);
  EXPECT_EQ(e.offset_ns(), 3'000'000'000);  // 100 us each way
}

TEST(ClockAsker, WithoutFollowUpTheAnswersOwnStampHasToDo) {
  Exchanging x;
  x.node.follows_up = false;
  x.run(milliseconds(200));
  ASSERT_FALSE(x.exchanges.empty());
  EXPECT_EQ(x.exchanges[0].kernel_stamps, 0b1011U);
  EXPECT_EQ(x.exchanges[0].round_trip_ns(), 250'000);
}

TEST(ClockAsker, SaysAtOnceThatANodeHasItsOwnClockThenWhatItShows) {
  Exchanging x;
  x.run(seconds(5));
  ASSERT_GE(x.fits.size(), 5U);
  EXPECT_EQ(x.fits[0].state, ClockState::kAcquire);
  EXPECT_EQ(x.fits[1].state, ClockState::kLocked);  // at the fourth exchange, not a second later
  EXPECT_LT(x.fits[1].host_ns - to_ns(kBegin), 100'000'000);
  for (std::size_t i = 1; i < x.fits.size(); ++i) {
    EXPECT_EQ(x.fits[i].number, x.fits[i - 1].number + 1);
    EXPECT_NEAR(static_cast<double>(x.fits[i].node_ns - x.fits[i].host_ns), 3e9, 1e3);
  }
  EXPECT_LE(x.fits.size(), 7U);
}

TEST(ClockAsker, ANodeThatDoesNotAnswerIsNeverLocked) {
  Exchanging x;
  x.node.answers = false;
  x.run(seconds(8));
  EXPECT_TRUE(x.exchanges.empty());
  for (const auto& fit : x.fits) EXPECT_EQ(fit.state, ClockState::kAcquire);
  // All but those of the last second, and of the second since the last fit.
  EXPECT_NEAR(static_cast<double>(x.fits.back().unanswered), x.node.asked - 12, 5);
  Exchanging nowhere;
  nowhere.node.address = {};
  nowhere.run(seconds(2));
  EXPECT_EQ(nowhere.node.asked, 0);
  EXPECT_FALSE(nowhere.fits.empty());
}

TEST(ClockAsker, ABreakIsSaidAtOnce) {
  Exchanging x;
  x.run(milliseconds(3200));
  x.fits.clear();
  x.node.ahead_ns += 500'000'000;
  x.run(milliseconds(500));
  ASSERT_FALSE(x.fits.empty());
  EXPECT_EQ(x.fits[0].breaks, 1);
}

TEST(ClockAsker, StrangersRepeatsAndForeignEpochsAreIgnored) {
  Exchanging x;
  x.node.answers = false;
  x.run(milliseconds(5));
  ClockDatagram answer{.kind = ClockDatagramKind::kAnswer, .node = 2, .epoch = 9, .number = 1};
  x.asker.take(answer, {0x0A000003, 4000}, {x.now, true});
  answer.number = 77;
  x.asker.take(answer, kThere, {x.now, true});
  answer = {.kind = ClockDatagramKind::kAnswer, .node = 2, .epoch = 8, .number = 1};
  x.asker.take(answer, kThere, {x.now, true});
  answer = {.kind = ClockDatagramKind::kFollowUp, .node = 2, .epoch = 9, .number = 1};
  x.asker.take(answer, kThere, {x.now, true});
  x.run(milliseconds(300));
  EXPECT_TRUE(x.exchanges.empty());
}

TEST(ClockAsker, ForgetsANodeThatIsGone) {
  Exchanging x;
  x.run(seconds(1));
  x.run(seconds(15), false);
  const int asked = x.node.asked;
  x.run(seconds(5), false);
  EXPECT_EQ(x.node.asked, asked);
}

}  // namespace
}  // namespace roadbalance
