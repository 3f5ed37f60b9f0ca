#include <gtest/gtest.h>
#include <sched.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/bus_route.hpp"
#include "hil_tests/measurement.hpp"
#include "hil_tests/network/three_hosts.hpp"

namespace roadbalance {
namespace {

using std::chrono::microseconds;
using test::CableFaults;
using test::Program;

/// The recorder on host 0, a node on each of two others; what a user types is the same but for the address.
class Network : protected test::ThreeHosts, public test::Measurement {
 protected:
  Network() : Measurement(test::kNetworkUrl) {}
  void SetUp() override {
    if (!hosts) GTEST_SKIP() << *test::Hosts::refusal();
  }

  Program node_on(std::size_t host, const std::string& name, const std::string& drive) {
    return hosts->on(host, [&] { return node(name, drive); });
  }
  void impair_all(const CableFaults& faults) {
    std::string by;
    for (std::size_t host = 0; host < 3; ++host) by = hosts->impair(host, faults);
    std::printf("frames are lost by %s\n", by.c_str());
  }
  void print_figures() {
    const auto counts = hosts->counts();
    std::printf("frames: %lld carried, %lld lost, %lld doubled, %lld unplugged\n",
                static_cast<long long>(counts.carried), static_cast<long long>(counts.lost),
                static_cast<long long>(counts.duplicated), static_cast<long long>(counts.unplugged));
    for (const int number : {kFront, kRear}) {
      const Heartbeat heartbeat = bus.heartbeat(number);
      std::printf("node %d: %lld blocks, %lld sent, %lld of them again: %.2f sends a block\n", number,
                  static_cast<long long>(heartbeat.next - 1), static_cast<long long>(heartbeat.blocks_sent),
                  static_cast<long long>(heartbeat.blocks_repaired),
                  static_cast<double>(heartbeat.blocks_sent) / static_cast<double>(heartbeat.next - 1));
    }
  }
};

// A run that a card puts together may begin with another program's message: a program that takes runs whole,
// as on a bus that stays on its computer, may not judge a run from elsewhere by its beginning.
TEST_F(Network, AFilterForRunsLeavesWhatComesOverTheCableToTheReader) {
  for (const auto& [where, left_outside] :
       {std::pair(std::string(test::kNetworkUrl), 3), std::pair(bus_url_on_port(BusAddress{}.port), 0)}) {
    Bus hearer(where);
    int heard = 0;
    hearer.subscribe("LAST", [&heard](std::string_view, auto) { ++heard; });
    EXPECT_EQ(hearer.handle(std::chrono::milliseconds(0)), 0);  // listens from now on
    hosts->on(1, [] {
      Bus sender(test::kNetworkUrl);
      for (const char* channel : {"RB_ACK_1", "RB_BLOCK_2_SCAN", "OTHER", "LAST"})
        EXPECT_TRUE(sender.publish(channel, std::vector<std::uint8_t>(100)));
      return 0;
    });
    while (heard == 0) ASSERT_GT(hearer.handle(std::chrono::seconds(5)), 0);
    EXPECT_EQ(hearer.dropped(), left_outside) << where;
  }
}

// With the remedy that the product itself names, and nothing more.
TEST_F(Network, AComputerWithoutANetworkIsReachedByItselfAt127001) {
  std::uint32_t address = 0;
  std::thread([&address] {
    ASSERT_EQ(::unshare(CLONE_NEWNET), 0);  // of this thread, and of what it starts
    EXPECT_EQ(address_on_bus(default_bus_url()), 0U) << "without a route";
    ASSERT_EQ(std::system(kMulticastRemedy), 0);
    address = address_on_bus(default_bus_url());
  }).join();
  EXPECT_EQ(address, 0x7F000001U);
}

// Obstacles between two computers are found before the drive.
TEST_F(Network, TheDoctorProvesTheWayToEveryHostByALoopOfMessages) {
  Program second = hosts->on(1, [] {
    return Program("rb", {"doctor", "--answer", "--url", test::kNetworkUrl});
  });
  Program third = hosts->on(2, [] {
    return Program("rb", {"doctor", "--answer", "--url", test::kNetworkUrl});
  });
  const auto ways = [&](const std::string& outcome) {
    const std::string said = work.path() / "doctor.json";
    const std::vector<std::string> words{
        "-c",
        "exec \"$0\" doctor --json --seconds 0.1 --folder \"$1\" --url \"$2\" >\"$3\"",
        test::binaries() / "rb",
        work.path(),
        test::kNetworkUrl,
        said};
    Program doctor = hosts->on(0, [&] { return Program("sh", words); });
    EXPECT_TRUE(doctor.exit_code(60.0).has_value());
    std::ifstream file(said);
    const auto findings = nlohmann::json::parse(file)["findings"];
    int found = 0;
    for (const auto& finding : findings) {
      const std::string sentence = finding["finding"];
      found += sentence.starts_with("Of messages to ") && sentence.find(outcome) != std::string::npos ? 1 : 0;
    }
    return found;
  };
  EXPECT_TRUE(test::wait_until([&] { return ways("all 1000 came") == 2; }, 60.0));
  impair_all({.loss = 0.1});
  EXPECT_EQ(ways(" of 1000 came"), 2);
  for (Program* answering : {&second, &third}) {
    answering->signal(SIGTERM);
    EXPECT_EQ(answering->exit_code(10.0), 0);
  }
}

TEST_F(Network, ThirtyPercentLossDuplicatesAndReorderEachWayLoseNothing) {
  impair_all({.loss = 0.3, .duplicates = 0.05, .longest = microseconds(5000)});
  Program running = recorder();
  const std::string drive = (test::full_run() ? "rate=10" : "rate=4") + std::string("&seconds=10000");
  Program front = node_on(1, "front", drive), rear = node_on(2, "rear", drive);
  const std::int64_t blocks = test::full_run() ? 30'000 : 1500;  // of 106 a second at rate=1
  ASSERT_TRUE(more_are_durable(kFront, blocks)) << bus.ack(kFront).durable;
  ASSERT_TRUE(more_are_durable(kRear, 1));
  EXPECT_GT(bus.heartbeat(kFront).blocks_repaired, 0);
  EXPECT_GT(bus.heartbeat(kRear).blocks_repaired, 0);
  print_figures();
  end_well(running, {&front, &rear});
  expect_complete(2);
  for (const char* name : {"front", "rear"}) expect_as_simulated(name, "seconds=10000");
}

TEST_F(Network, OneWayLossEitherWayLosesNothing) {
  Program running = recorder();
  const std::string drive = "rate=4&seconds=10000";
  Program front = node_on(1, "front", drive), rear = node_on(2, "rear", drive);
  ASSERT_TRUE(more_are_durable(kFront, 100));
  hosts->impair(0, {.loss = 0.6});  // from the recorder
  ASSERT_TRUE(more_are_durable(kFront, 500));
  hosts->impair(0, {});
  hosts->impair(1, {.loss = 0.6});  // from the node in front
  ASSERT_TRUE(more_are_durable(kFront, 500));
  ASSERT_TRUE(more_are_durable(kRear, 100));
  print_figures();
  end_well(running, {&front, &rear});
  expect_complete(2);
  for (const char* name : {"front", "rear"}) expect_as_simulated(name, "seconds=10000");
}

TEST_F(Network, ACablePulledAndPluggedInAgainLosesNothing) {
  Program running = recorder();
  const std::string drive = "rate=1&seconds=10000";
  Program front = node_on(1, "front", drive), rear = node_on(2, "rear", drive);
  ASSERT_TRUE(more_are_durable(kFront, 100));
  ASSERT_TRUE(more_are_durable(kRear, 100));

  hosts->pull(1);
  bus.listen(0.2);  // what was under way has come
  const std::int64_t heard = bus.heartbeat(kFront).next;
  bus.listen(test::full_run() ? 10.0 : 2.5);
  EXPECT_EQ(bus.heartbeat(kFront).next, heard) << "the cable is still plugged in";
  ASSERT_TRUE(more_are_durable(kRear, 50)) << "the other node must not care";
  const auto plugged = WallClock::now();
  hosts->plug(1);
  // At real time 30 blocks are what is on its way between two syncs.
  ASSERT_TRUE(bus.wait([&] {
    const Heartbeat heartbeat = bus.heartbeat(kFront);
    return heartbeat.next > heard && heartbeat.ring_used < 60;
  }));
  std::printf("backlog gone %.2f s after the cable was plugged in\n",
              std::chrono::duration<double>(WallClock::now() - plugged).count());
  ASSERT_TRUE(more_are_durable(kFront, 100));
  end_well(running, {&front, &rear});
  expect_complete(2);
  for (const char* name : {"front", "rear"}) expect_as_simulated(name, "seconds=10000");
}

// The kernel ties a membership in the group to an interface.
TEST_F(Network, ANetworkCardPutInAgainLosesNothing) {
  Program running = recorder();
  const std::string drive = "rate=1&seconds=10000";
  Program front = node_on(1, "front", drive), rear = node_on(2, "rear", drive);
  for (const std::size_t host : {1U, 0U}) {
    ASSERT_TRUE(more_are_durable(kFront, 100));
    hosts->replace_interface(host);
    ASSERT_TRUE(more_are_durable(kFront, 200)) << host;
    ASSERT_TRUE(more_are_durable(kRear, 50)) << host;
  }
  end_well(running, {&front, &rear});
  expect_complete(2);
  for (const char* name : {"front", "rear"}) expect_as_simulated(name, "seconds=10000");
}

}  // namespace
}  // namespace roadbalance
