#include "host/recorder/clock_asker.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

#include "common/clock/test/simulated_clocks.hpp"

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
  double drift = 0.0;  ///< since kBegin
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
    datagram.received_ns = to_ns(now) + 100'000 + node.ahead_ns +
                           std::llround(node.drift * static_cast<double>((now - kBegin).count()));
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

// The host's clock is off by less than what would prove a break by itself.
TEST(ClockAsker, BeginsAnewBehindASleepOfTheHost) {
  Exchanging x;
  x.run(seconds(20));
  ASSERT_EQ(x.fits.back().state, ClockState::kLocked);
  ASSERT_EQ(x.fits.back().breaks, 0);
  const std::size_t before = x.fits.size();
  x.now += seconds(60);
  x.node.ahead_ns += 300'000;
  x.asker.host_slept();
  x.run(seconds(5));
  ASSERT_GT(x.fits.size(), before);
  EXPECT_EQ(x.fits[before].breaks, 1);
  EXPECT_FALSE(x.fits[before].is_known());
  const ClockFit& last = x.fits.back();
  EXPECT_EQ(last.state, ClockState::kLocked);
  EXPECT_EQ(last.breaks, 1);
  EXPECT_NEAR(static_cast<double>(last.node_ns - last.host_ns), 3'000'300'000.0, 1'000.0);
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

/// A recorder and a node with real crystals and ways between them; each fit is judged for as long as it is
/// the last.
class Judged {
 public:
  explicit Judged(std::uint64_t seed) : clocks_(seed) {}

  void begin_recorder() {
    asker_ = ClockAsker();
    fit_.reset();
  }
  void run(double time_s) {
    for (const double end_s = clocks_.now_s() + time_s; clocks_.now_s() < end_s; clocks_.pass(5e-3)) {
      asker_.heard({.node = 2, .epoch = 9, .address = kThere}, now());
      for (const auto& question : asker_.due(now())) ask(question);
      (void)asker_.exchanges(now());
      judge();
      for (const ClockFit& fit : asker_.fits(now())) use(fit);
    }
    judge();
    close();
  }
  void pull(double time_s) {
    for (const double end_s = clocks_.now_s() + time_s; clocks_.now_s() < end_s; clocks_.pass(0.1)) {
      (void)asker_.due(now());
      (void)asker_.fits(now());
    }
  }

  int windows = 0, covered = 0;
  int first = 0,
      first_covered = 0;  ///< of them those of the first fit that is known, after a beginning or a pull

 private:
  MachineTime now() const { return machine_time_from_ns(clocks_.host_ns()); }
  void ask(const ClockAsker::Question& question) {
    const auto e = clocks_.exchange(question.datagram.number);
    ClockDatagram datagram = question.datagram;
    asker_.sent(question, {e ? machine_time_from_ns(e->asked_ns) : now(), true});
    if (!e) return;
    datagram.kind = ClockDatagramKind::kAnswer;
    datagram.received_ns = e->received_ns;
    datagram.answered_ns = e->answered_ns;
    asker_.take(datagram, kThere, {machine_time_from_ns(e->heard_ns), true});
    datagram.kind = ClockDatagramKind::kFollowUp;
    asker_.take(datagram, kThere, {machine_time_from_ns(e->heard_ns), true});
  }
  void judge() {
    if (!fit_) return;
    const std::int64_t error_ns = fit_->host_time_ns(clocks_.node_ns()) - clocks_.host_ns();
    is_inside_ = is_inside_ && 1e-9 * static_cast<double>(std::abs(error_ns)) <= fit_->uncertainty_s;
  }
  void close() {
    if (!fit_) return;
    ++windows;
    covered += is_inside_ ? 1 : 0;
    if (!was_known_) ++first, first_covered += is_inside_ ? 1 : 0;
    was_known_ = true;
    fit_.reset();
  }
  void use(const ClockFit& fit) {
    if (!fit_) was_known_ = false;
    close();
    if (!fit.is_known()) return;
    fit_ = fit;
    is_inside_ = true;
  }

  test::SimulatedClocks clocks_;
  ClockAsker asker_;
  std::optional<ClockFit> fit_;
  bool is_inside_ = true, was_known_ = false;
};

TEST(ClockAsker, StatedUncertaintyCoversTheErrorFromTheFirstFitOn) {
  int windows = 0, covered = 0, first = 0, first_covered = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Judged judged(seed);
    for (const double pull_s : {15.0, 60.0, 180.0}) {
      judged.begin_recorder();
      judged.run(10.0 + 0.01 * static_cast<double>(seed));
      judged.pull(pull_s);
      judged.run(5.0);
    }
    windows += judged.windows, covered += judged.covered;
    first += judged.first, first_covered += judged.first_covered;
  }
  std::printf("windows %d covered %.3f %%; first ones %d covered %.3f %%\n", windows,
              100.0 * covered / windows, first, 100.0 * first_covered / first);
  EXPECT_GT(windows, 14'000);
  EXPECT_EQ(first, 1'800);
  EXPECT_GE(covered, windows * 0.999);
  EXPECT_GE(first_covered, first * 0.999);
}

TEST(ClockAsker, KnowsTheDriftOverALongPull) {
  Exchanging x;
  x.node.drift = 40e-6;
  x.run(seconds(60));
  x.run(seconds(120), false);
  x.fits.clear();
  const int asked = x.node.asked;
  x.run(milliseconds(200));
  EXPECT_GE(x.node.asked - asked, 8) << "in a burst again";
  ASSERT_FALSE(x.fits.empty());
  for (const ClockFit& fit : x.fits) EXPECT_NEAR(fit.drift, 40e-6, 1e-6);
}

TEST(ClockAsker, CountsBreaksOverAPull) {
  Exchanging x;
  x.run(seconds(4));
  x.node.ahead_ns += 500'000'000;
  x.run(seconds(2));
  x.run(seconds(15), false);
  x.run(seconds(2));
  x.node.ahead_ns += 500'000'000;
  x.run(seconds(2));
  EXPECT_EQ(x.fits.back().breaks, 2);
}

TEST(ClockAsker, TheOneSilentForLongestMakesRoom) {
  ClockAsker asker;
  const auto hear = [&](std::size_t k, MachineTime at) {
    asker.heard({.node = 2, .epoch = static_cast<std::int64_t>(k), .address = kThere}, at);
  };
  for (std::size_t k = 0; k <= 2 * kMostNodes; ++k) hear(k, kBegin + milliseconds(k));
  EXPECT_EQ(asker.due(kBegin + seconds(1)).size(), 2 * kMostNodes) << "nobody is silent: no room";
  for (std::size_t k = 1; k < 2 * kMostNodes; ++k) hear(k, kBegin + seconds(10));
  hear(2 * kMostNodes, kBegin + seconds(11));
  const auto questions = asker.due(kBegin + seconds(12));
  EXPECT_EQ(questions.size(), 2 * kMostNodes);
  EXPECT_EQ(questions.front().datagram.epoch, 1);
  EXPECT_EQ(questions.back().datagram.epoch, static_cast<std::int64_t>(2 * kMostNodes));
}

TEST(ClockAsker, AsksANodeThatIsGoneNoMore) {
  Exchanging x;
  x.run(seconds(1));
  x.run(seconds(15), false);
  const int asked = x.node.asked;
  x.run(seconds(5), false);
  EXPECT_EQ(x.node.asked, asked);
}

}  // namespace
}  // namespace roadbalance
