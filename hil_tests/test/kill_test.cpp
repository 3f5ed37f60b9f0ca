#include <gtest/gtest.h>

#include "common/test/bus_url.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "hil_tests/program.hpp"
#include "host/recorder/verify.hpp"

namespace roadbalance {
namespace {

using test::Program;

constexpr double kPatience_s = 60;  // a bound for slow machines and sanitizers, not a measurement

class Kill : public ::testing::Test {
 protected:
  Program recorder() {
    return {"rb-recorder", {"--record", record.path(), "--url", url, "--nodes", "1", "--end-with-nodes"}};
  }
  // Twenty times real time, so that the drive lasts while programs come and go.
  Program node(int seconds) {
    return {"rb-node",
            {"--vehicle", test::source_path("sim/demo/vehicle.toml"), "--node", "front", "--url", url,
             "--front-end", "sim:?seed=3&rate=20&seconds=" + std::to_string(seconds)}};
  }
  std::int64_t samples_recorded() const {
    std::int64_t samples = 0;
    for (const auto& epoch : verify_record(record.path()).epoch) samples += epoch.samples;
    return samples;
  }
  bool recorded(std::int64_t samples) const {
    return test::wait_until([&] { return samples_recorded() >= samples; }, kPatience_s);
  }

  const test::TemporaryDirectory record;
  const std::string url = test::bus_url();
};

TEST_F(Kill, ARecorderKilledWhileRecordingLosesNothing) {
  const Program running_node = node(80);
  std::int64_t samples = 1;
  for (int k = 0; k < 3; ++k) {
    Program killed = recorder();
    ASSERT_TRUE(recorded(samples));
    killed.kill();
    samples = samples_recorded() + 1;
    EXPECT_EQ(verify_record(record.path()).verdict, Verdict::kIncomplete)
        << "no end yet, but no damage either";
  }
  Program last = recorder();
  ASSERT_EQ(last.exit_code(kPatience_s), 0);

  const Verification verification = verify_record(record.path());
  EXPECT_EQ(verification.verdict, Verdict::kComplete);
  ASSERT_EQ(verification.epoch.size(), 1u);
  EXPECT_EQ(verification.epoch[0].samples, verification.epoch[0].samples_sent);
  EXPECT_GE(verification.epoch[0].samples, samples)
      << "and what was recorded before each kill is still there";
}

TEST_F(Kill, ANodeKilledAndRestartedIsANewEpochAndTheOldOnesEndIsDeclared) {
  Program running_recorder = recorder();
  {
    Program killed = node(300);
    ASSERT_TRUE(recorded(2000));
  }
  const Program restarted = node(20);
  ASSERT_EQ(running_recorder.exit_code(kPatience_s), 0);

  const Verification verification = verify_record(record.path());
  EXPECT_EQ(verification.verdict, Verdict::kIncomplete);
  ASSERT_EQ(verification.epoch.size(), 2u);
  const VerifiedEpoch& killed = verification.epoch[0];
  EXPECT_FALSE(killed.ended);
  ASSERT_FALSE(killed.gaps.empty());
  EXPECT_EQ(killed.gaps.back().cause, GapCause::kNodeCrash);
  EXPECT_EQ(killed.gaps.back().first_scan, killed.samples + killed.samples_missing);
  EXPECT_TRUE(verification.epoch[1].is_complete());
  EXPECT_GT(verification.epoch[1].samples, 0);
}

}  // namespace
}  // namespace roadbalance
