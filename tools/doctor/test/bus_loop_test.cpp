#include "tools/doctor/bus_loop.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "common/test/bus_url.hpp"

namespace roadbalance {
namespace {

/// Acts on the bus at every message that it hears.
template <typename Do>
std::jthread meddler(const std::string& url, Do act) {
  return std::jthread([=](const std::stop_token& stop) {
    Bus bus(url);
    bus.subscribe("RB_DOCTOR", [&](std::string_view channel, std::span<const std::uint8_t> bytes) {
      act(bus, std::string(channel), bytes);
    });
    while (!stop.stop_requested()) bus.handle(std::chrono::milliseconds(20));
  });
}

TEST(BusLoop, CountsWhatComesBack) {
  const std::string url = test::bus_url();
  BusLoop loop(url);
  loop.run(200);
  EXPECT_EQ(loop.sent(), 200);
  EXPECT_GT(loop.receive_buffer(), 0);
  // On a busy machine some may be lost; the loop is there to report that.
  EXPECT_GT(loop.own().came(), 0);
  EXPECT_LE(loop.own().came(), 200);
  EXPECT_GT(loop.own().within_ms(0.5), 0.0);
  EXPECT_LE(loop.own().within_ms(0.5), loop.own().within_ms(1.0));
  EXPECT_TRUE(loop.answers().empty());
  EXPECT_EQ(loop_findings(loop, "").front().state,
            loop.own().came() == 200 ? Finding::kWell : Finding::kNote);
}

TEST(BusLoop, HearsWhoAnswers) {
  const std::string url = test::bus_url();
  std::stop_source stop;
  std::jthread first([&] { answer_loops(url, stop.get_token()); });
  std::jthread second([&] { answer_loops(url, stop.get_token()); });
  // Both have to be there before the first message.
  for (int attempt = 0; attempt < 100; ++attempt) {
    BusLoop loop(url);
    loop.run(50);
    if (loop.answers().size() < 2) continue;
    loop.run(100);
    stop.request_stop();
    for (const auto& [who, way] : loop.answers()) {
      EXPECT_GT(way.came(), 50) << "some of the second run, too";
      EXPECT_FALSE(way.name.empty());
      EXPECT_GE(way.within_ms(0.5), 0.0);
    }
    return;
  }
  stop.request_stop();
  FAIL() << "two that answer were never heard";
}

// The same message again is none that came; another program's message, or half of one, is none at all.
TEST(BusLoop, CountsEachMessageOnce) {
  const std::string url = test::bus_url();
  std::atomic<int> told = 0;
  const auto twice =
      meddler(url, [&](Bus& bus, const std::string& channel, std::span<const std::uint8_t> bytes) {
        if (++told > 100) return;  // it hears itself
        bus.publish(channel, bytes);
        bus.publish(channel, bytes.first(bytes.size() / 2));
        std::vector<std::uint8_t> other(bytes.begin(), bytes.end());
        other[0] ^= 1U;
        bus.publish(channel, other);
      });
  BusLoop loop(url);
  for (int attempt = 0; attempt < 100 && told == 0; ++attempt) loop.run(20);
  EXPECT_GT(told, 0);
  EXPECT_LE(loop.own().came(), loop.sent());
  EXPECT_EQ(std::ssize(loop.own().back_ms), loop.own().came());
  EXPECT_TRUE(loop.answers().empty());
}

TEST(LoopFindings, NameTheWayThatLosesAndWhatIsMissing) {
  BusLoop loop(test::bus_url());
  const auto all = loop_findings(loop, "udpm://239.255.76.67:7667?ttl=0");
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].state, Finding::kIll) << "nothing was sent, nothing came";
  EXPECT_EQ(all[1].name, "ttl");
  EXPECT_NE(all[1].remedy.find("?ttl=1"), std::string::npos) << all[1].remedy;
  const auto wide = loop_findings(loop, "udpm://239.255.76.67:7667?ttl=1");
  EXPECT_EQ(wide[1].name, "ways");
  EXPECT_NE(wide[1].remedy.find("--answer"), std::string::npos) << wide[1].remedy;
}

}  // namespace
}  // namespace roadbalance
