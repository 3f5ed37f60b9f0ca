// rb-mpi identify under mpirun on this machine: byte for byte what rb identify prints.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "common/test/temporary_directory.hpp"
#include "tools/mpi/test/mpirun.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/test/simulated_drives.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using test::mpirun;
using test::Output;
using test::output_of;
using test::program;

class ClusterIdentify : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    drives_ = new test::TemporaryDirectory;
    for (int i = 0; i < 5; ++i)
      test::record_drive(
          {.seed = static_cast<std::uint64_t>(i + 1), .speed_km_h = 110.0 + 4.0 * i, .seconds = 30.0},
          drives_->path() / ("drive-" + std::to_string(i)), test::slow_car());
  }
  static void TearDownTestSuite() { delete drives_; }
  static std::string all() { return " identify --json " + drives_->path().string(); }

  static inline test::TemporaryDirectory* drives_ = nullptr;
  const test::TemporaryDirectory folder_;
};

TEST_F(ClusterIdentify, SaysTheSameBitForBitHoweverManyProcesses) {
  const Output alone = output_of(program("rb") + all());
  ASSERT_EQ(alone.status, kDone) << alone.errors;
  for (const int processes : {1, 2, 4}) {
    const Output together = output_of(mpirun(processes) + program("rb-mpi") + all());
    EXPECT_EQ(together.text, alone.text) << processes << together.errors;
    EXPECT_EQ(together.status, alone.status);
  }
  const Output threads = output_of(mpirun(2) + program("rb-mpi") + all() + " --jobs 2");
  EXPECT_EQ(threads.text, alone.text) << threads.errors;
}

TEST_F(ClusterIdentify, OfOneRecordingOrMoreProcessesThanRecordingsStillAnswers) {
  const std::string one = " identify --json " + (drives_->path() / "drive-0").string();
  const std::string two = one + " " + (drives_->path() / "drive-1").string();
  for (const std::string& arguments : {one, two}) {
    const Output alone = output_of(program("rb") + arguments);
    const Output together = output_of(mpirun(4) + program("rb-mpi") + arguments);
    EXPECT_EQ(together.text, alone.text) << together.errors;
    EXPECT_EQ(together.status, alone.status) << together.errors;
  }
}

/// How often a sentence is in a text.
int times(const std::string& text, const std::string& sentence) {
  int count = 0;
  for (std::size_t at = 0; (at = text.find(sentence, at)) != std::string::npos; ++at) ++count;
  return count;
}

TEST_F(ClusterIdentify, SaysOnceWhatIsWrongAndEnds) {
  const fs::path bad = folder_.path() / "a-short";
  test::record_drive({.seed = 77, .seconds = 6.0}, bad, test::slow_car());
  for (const int processes : {2, 4}) {
    const Output brief = output_of(mpirun(processes) + program("rb-mpi") + all() + " " + bad.string());
    EXPECT_EQ(brief.status, kAnswerIsNo) << brief.errors;
    EXPECT_EQ(times(brief.errors, "a-short: too short"), 1) << brief.errors;
    EXPECT_TRUE(brief.text.empty());
  }
  const Output skipped =
      output_of(mpirun(3) + program("rb-mpi") + all() + " --skip-unusable " + bad.string());
  EXPECT_EQ(skipped.status, kDone) << skipped.errors;
  EXPECT_EQ(skipped.text, output_of(program("rb") + all() + " --skip-unusable " + bad.string()).text);

  const fs::path other = folder_.path() / "z-other";
  test::record_drive({.seed = 99}, other,
                     test::replaced(test::slow_car(), "datum_deg = 30\n", "datum_deg = 31\n"));
  const Output mixed = output_of(mpirun(3) + program("rb-mpi") + all() + " " + other.string());
  EXPECT_EQ(mixed.status, kUsage) << mixed.errors;
  EXPECT_EQ(times(mixed.errors, "do not belong together: wheel front_left: datum_deg"), 1) << mixed.errors;
}

}  // namespace
}  // namespace roadbalance
