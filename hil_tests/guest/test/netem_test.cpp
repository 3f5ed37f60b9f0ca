#include <gtest/gtest.h>

#include <cstdio>

#include "hil_tests/measurement.hpp"
#include "hil_tests/network/three_hosts.hpp"

namespace roadbalance {
namespace {

using test::Program;

/// The recorder on host 0, a node on each of two others; the kernel's netem harms what each of them sends.
class Netem : protected test::ThreeHosts, public test::Measurement {
 protected:
  Netem() : Measurement(test::kNetworkUrl) {}

  void SetUp() override { ASSERT_TRUE(hosts) << *test::Hosts::refusal(); }

  /// Records two nodes under the fault; nothing may be missing.  Returns the nodes' repeated sends.
  std::int64_t record_under(const std::vector<std::string>& fault) {
    for (std::size_t host = 0; host < 3; ++host)
      EXPECT_TRUE(hosts->netem(host, fault)) << "the guest's kernel has netem";
    Program running = recorder();
    const std::string drive = "rate=1&seconds=10000";
    Program front = hosts->on(1, [&] { return node("front", drive); });
    Program rear = hosts->on(2, [&] { return node("rear", drive); });
    EXPECT_TRUE(more_are_durable(kFront, 200));
    EXPECT_TRUE(more_are_durable(kRear, 1));
    const std::int64_t repaired =
        bus.heartbeat(kFront).blocks_repaired + bus.heartbeat(kRear).blocks_repaired;
    std::printf("%lld blocks, %lld sent again\n",
                static_cast<long long>(bus.heartbeat(kFront).next + bus.heartbeat(kRear).next - 2),
                static_cast<long long>(repaired));
    end_well(running, {&front, &rear});
    expect_verified(record, 2);
    return repaired;
  }
};

TEST_F(Netem, TenPercentLossLosesNothing) {
  EXPECT_GT(record_under({"loss", "10%"}), 0) << "nothing was harmed";
}

TEST_F(Netem, ReorderingLosesNothing) {
  record_under({"delay", "20ms", "10ms", "reorder", "25%", "50%"});
}

TEST_F(Netem, DuplicatesAreRecordedOnce) {
  record_under({"duplicate", "5%"});
}

// A wrong bit anywhere in a frame; IP and UDP drop most of them, the rest are for the link's CRC.
TEST_F(Netem, CorruptionLosesNothing) {
  EXPECT_GT(record_under({"corrupt", "5%"}), 0) << "nothing was harmed";
}

TEST_F(Netem, AllOfItTogetherLosesNothing) {
  EXPECT_GT(record_under({"loss", "10%", "duplicate", "5%", "corrupt", "5%", "delay", "5ms", "2ms"}), 0);
}

}  // namespace
}  // namespace roadbalance
