#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

#include "hil_tests/measurement.hpp"
#include "hil_tests/private_mounts.hpp"
#include "hil_tests/test/operating_fixture.hpp"

namespace roadbalance {
namespace {

using test::Program;
namespace fs = std::filesystem;

/// The disk of the recordings comes after the recorder.
class OperatingDisk : public Operating {
 protected:
  static void SetUpTestSuite() { refusal() = test::enter_private_mounts(); }
  void SetUp() override {
    if (!refusal()) refusal() = test::FailingDisk::refusal();
    if (refusal()) GTEST_SKIP() << *refusal();
    fs::create_directories(recordings);
  }
  static std::optional<std::string>& refusal() {
    static std::optional<std::string> why;
    return why;
  }

  static constexpr int kMebibytes = 128;
  const fs::path image = work.path() / "image";
};

TEST_F(OperatingDisk, OneThatIsMountedWhileThereIsNoWorkTakesTheNextRecording) {
  Program recorder = operated_recorder(), front = staying("front"), rear = staying("rear");
  start("beneath");
  stop();
  expect_whole("beneath");
  test::FailingDisk disk(image, recordings, kMebibytes);
  bus.listen(2.0);
  start("mounted");
  stop();
  expect_whole("mounted");
  EXPECT_FALSE(fs::exists(recordings / "beneath")) << "it is not the disk";
  recorder.signal(SIGTERM);
  EXPECT_EQ(recorder.exit_code(30), 0);
}

// As a USB disk at the start of a computer that was recording.
TEST_F(OperatingDisk, ARecordingUnderWayGoesOnWhenItsDiskComes) {
  test::FailingDisk disk(image, recordings, kMebibytes);
  std::optional<Program> recorder(operated_recorder());
  Program front = staying("front"), rear = staying("rear");
  start("drive");
  ASSERT_TRUE(more_are_durable(kFront, 100));
  recorder->kill();
  disk.unmount();
  recorder.emplace(operated_recorder());
  ASSERT_TRUE(bus.wait([&] { return bus.recorder() && bus.recorder()->state == RecorderState::kArmed; }));
  disk.repair();
  ASSERT_TRUE(bus.wait([&] { return bus.recorder()->state == RecorderState::kRecording; }));
  stop();
  expect_whole("drive");
  recorder->signal(SIGTERM);
  EXPECT_EQ(recorder->exit_code(30), 0);
}

}  // namespace
}  // namespace roadbalance
