#include <gtest/gtest.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <string>

#include "hil_tests/measurement.hpp"
#include "hil_tests/memory_trend.hpp"

namespace roadbalance {
namespace {

using test::Program;

class Flood : public test::Measurement {
 protected:
  std::string port() const {
    const auto colon = url.rfind(':');
    return url.substr(colon + 1, url.find('?') - colon - 1);
  }
};

TEST_F(Flood, TenThousandMalformedDatagramsASecondCostNoSample) {
  const int seconds = test::full_run() ? 60 : 5;  // 35 MB
  Program running = recorder();
  // In real time: at any other rate the simulated device would wait for its reader.
  Program front = node("front", "rate=1&seconds=10000"), rear = node("rear", "rate=1&seconds=10000");
  ASSERT_TRUE(more_are_durable(kFront, 50));
  ASSERT_TRUE(more_are_durable(kRear, 50));
  // Any other LCM 1.3.1 receiver shows that the deadly ones are deadly.
  const std::filesystem::path heard = work / "victim.lcm";
  Program victim("lcm-logger", {"--quiet", "--lcm-url=" + url, heard});
  const auto hears = [&] { return std::filesystem::exists(heard) && std::filesystem::file_size(heard) > 0; };
  ASSERT_TRUE(bus.wait(hears)) << "lcm-logger does not log";

  const auto memory_before = test::own_memory_bytes(running.pid());
  Program flood("rb-flood", {"--bus-port", port(), "--seconds", std::to_string(seconds)});
  EXPECT_EQ(flood.exit_code(seconds + test::BusWatch::kPatience_s), 0);
  const auto memory_after = test::own_memory_bytes(running.pid());
  EXPECT_EQ(victim.exit_code(test::BusWatch::kPatience_s), 128 + SIGSEGV)
      << "the crafted datagrams did not reach the bus";

  ASSERT_TRUE(memory_before && memory_after) << "the recorder is gone";
  const double growth_mib = static_cast<double>(*memory_after - *memory_before) / (1 << 20);
  std::printf("the recorder's memory grew by %.2f MiB\n", growth_mib);
#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)  // which keep memory of their own
  EXPECT_LT(growth_mib, 1) << "of ten thousands of datagrams of 0.7 kB nothing is kept";
#endif
  EXPECT_TRUE(bus.wait([&] { return bus.recorder() && bus.recorder()->refused_datagrams > 0; }))
      << "what was refused is not counted";

  ASSERT_TRUE(more_are_durable(kFront, 50)) << "recording goes on";
  ASSERT_TRUE(more_are_durable(kRear, 50));
  end_well(running, {&front, &rear});
  expect_complete(2);
  for (const char* name : {"front", "rear"}) expect_as_simulated(name, "seconds=10000");
}

}  // namespace
}  // namespace roadbalance
