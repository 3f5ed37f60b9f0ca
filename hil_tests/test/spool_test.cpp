#include <gtest/gtest.h>

#include "hil_tests/measurement.hpp"

namespace roadbalance {
namespace {

using test::Program;

class Spool : public test::Measurement {};

TEST_F(Spool, ANodesDiskKeepsWhatItsMemoryCannotWhileTheRecorderIsAway) {
  const auto spool = work.path() / "spool";
  Program front = node("front", "rate=4&seconds=10000", {"--ring-mib", "0.5", "--spool", spool});
  {
    Program killed = recorder();
    ASSERT_TRUE(more_are_durable(kFront, 100));
  }
  const std::int64_t memory_blocks = 512 * 1024 / static_cast<std::int64_t>(sizeof(SealedBlock));
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).spool_used > 3 * memory_blocks; }));
  EXPECT_EQ(bus.heartbeat(kFront).scans_missing, 0);
  EXPECT_EQ(bus.heartbeat(kFront).spool_failures, 0);

  Program running = recorder();
  ASSERT_TRUE(bus.wait([&] { return bus.heartbeat(kFront).spool_used == 0; }));
  ASSERT_TRUE(more_are_durable(kFront, 100));
  end_well(running, {&front});
  expect_complete(1);
  expect_as_simulated("front", "seconds=10000");
  if (!std::filesystem::exists(spool)) return;
  for (const auto& file : std::filesystem::recursive_directory_iterator(spool))
    EXPECT_NE(file.path().extension(), ".lcm") << "not needed any more: " << file.path();
}

}  // namespace
}  // namespace roadbalance
