#include "host/recorder/control/operate.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "common/test/bus_url.hpp"
#include "common/test/temporary_directory.hpp"
#include "host/recorder/control/session_state.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

class OperateTest : public ::testing::Test {
 protected:
  OperateTest() {
    options.recorder.url = test::bus_url();
    options.recordings = work.path() / "recordings";
    stop.request_stop();  // a recorder that begins ends at once
  }
  /// Why it is refused; empty: it began.
  std::string refused_for() const {
    try {
      operate(stop.get_token(), options);
      return "";
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  }

  const test::TemporaryDirectory work;
  OperateOptions options;
  std::stop_source stop;
};

TEST_F(OperateTest, APowerLineThatIsNoneIsRefusedBeforeAnybodyAsksForARecording) {
  for (const char* line : {"gpio:gpiochip0", "gpio:gpiochip0:1:high", "supply:", "mains"}) {
    options.recorder.power = line;
    EXPECT_NE(refused_for().find(line), std::string::npos) << line;
    EXPECT_FALSE(fs::exists(options.recordings)) << line;
  }
}

TEST_F(OperateTest, APowerLineThatIsNoneIsRefusedAlsoWhereARecordingIsUnderWay) {
  fs::create_directories(options.recordings / "monday");
  SessionState state;
  state.active = ActiveRecording{.name = "monday", .began_us = 1'769'860'805'000'000};
  write_session_state(options.recordings, state);
  options.recorder.power = "gpio:gpiochip0";
  EXPECT_NE(refused_for().find("gpio:gpiochip0"), std::string::npos);
  EXPECT_TRUE(read_session_state(options.recordings).active) << "it goes on when the mistake is mended";
}

TEST_F(OperateTest, TheRecordingsFolderIsNotAlsoItsOwnFallback) {
  options.recorder.fallback = work.path() / "x" / ".." / "recordings" / "";
  EXPECT_NE(refused_for().find(options.recorder.fallback.string()), std::string::npos);
  EXPECT_FALSE(fs::exists(options.recordings));
}

// Its module may be loaded later: a request for a recording is refused with the reason, as by --record.
TEST_F(OperateTest, APowerLineThatIsNotThereYetRefusesARecordingButNotTheRecorder) {
  options.recorder.power = "supply:nosuch";
  EXPECT_EQ(refused_for(), "");

  stop = std::stop_source();
  options.start = "monday";
  std::string warning;
  options.recorder.on_warning = [&](const std::string& sentence) {
    warning += sentence;
    stop.request_stop();
  };
  EXPECT_EQ(refused_for(), "");
  EXPECT_NE(warning.find("supply:nosuch cannot be read"), std::string::npos) << warning;
  EXPECT_FALSE(fs::exists(options.recordings / "monday"));
}

}  // namespace
}  // namespace roadbalance
