#include "common/process/in_order.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <stdexcept>
#include <string>

namespace roadbalance {
namespace {

std::vector<int> pieces(int count) {
  std::vector<int> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

TEST(InOrder, TakesEveryResultInOrderHoweverManyWork) {
  for (const std::size_t jobs : {1U, 2U, 7U, 200U}) {
    std::vector<int> taken;
    in_order<int>(
        pieces(100), jobs, {}, [](int piece, const std::stop_token&) { return piece * piece; },
        [&](int piece, int result) {
          EXPECT_EQ(result, piece * piece);
          taken.push_back(piece);
        });
    EXPECT_EQ(taken, pieces(100)) << jobs;
  }
}

TEST(InOrder, OfNothingTakesNothing) {
  in_order<int>(
      pieces(0), 4, {}, [](int, const std::stop_token&) { return 0; }, [](int, int) { FAIL(); });
}

TEST(InOrder, IsNeverMoreThanItsBoundAhead) {
  std::atomic<int> done = 0;
  int taken = 0;
  in_order<int>(
      pieces(60), 3, {},
      [&](int, const std::stop_token&) {
        ++done;
        return 0;
      },
      [&](int, int) {
        // For each of three: one waits to be sent, one waits to be taken, one was just taken by this one.
        EXPECT_LE(done, taken + 3 * 3);
        ++taken;
      });
}

TEST(InOrder, SaysWhichWorkFailed) {
  const auto run = [] {
    in_order<int>(
        pieces(50), 2, {},
        [](int piece, const std::stop_token&) {
          if (piece == 20) throw std::runtime_error("piece 20");
          return 0;
        },
        [](int piece, int) { EXPECT_LT(piece, 20 + 1); });
  };
  EXPECT_THROW(run(), std::runtime_error);
}

TEST(InOrder, TellsWorkToStopWhenTakingFails) {
  std::atomic<int> done = 0;
  EXPECT_THROW(in_order<int>(
                   pieces(1000), 2, {}, [&](int, const std::stop_token&) { return ++done; },
                   [](int, int) { throw std::runtime_error("no more"); }),
               std::runtime_error);
  EXPECT_LT(done, 10);
}

TEST(InOrder, HandsARequestToStopOn) {
  std::stop_source stop;
  int taken = 0;
  EXPECT_THROW(in_order<int>(
                   pieces(1000), 2, stop.get_token(),
                   [](int, const std::stop_token& told) {
                     if (told.stop_requested()) throw std::runtime_error("stopped");
                     return 0;
                   },
                   [&](int, int) {
                     if (++taken == 5) stop.request_stop();
                   }),
               std::runtime_error);
  EXPECT_LT(taken, 20);
}

}  // namespace
}  // namespace roadbalance
