#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "common/bus/bus.hpp"
#include "common/test/temporary_directory.hpp"
#include "host/recorder/recorder.hpp"

namespace roadbalance {
namespace {

class RecorderPowerTest : public ::testing::Test {
 protected:
  RecorderPowerTest() {
    options.url = bus_url_on_port(20'000 + ::getpid() % 20'000);
    options.folder = work.path() / "record";
    options.power = "supply:nosuch";
  }

  const test::TemporaryDirectory work;
  RecorderOptions options;
};

TEST_F(RecorderPowerTest, NamesTheSupplyItCannotReadBeforeARecordingBegins) {
  try {
    run_recorder({}, options);
    FAIL() << "watches a supply that is not there";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("supply:nosuch"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(options.folder));
}

TEST_F(RecorderPowerTest, ARecordingGoesOnThoughTheSupplyCannotBeReadAnyMore) {
  std::filesystem::create_directories(options.folder);
  std::ofstream(options.folder / "incarnation") << "5\n";
  std::stop_source stop;
  options.on_alive = [&](const RecorderStatus& status) {
    if (status.power_unknown) stop.request_stop();
  };
  int warnings = 0;
  options.on_warning = [&](const std::string& sentence) {
    if (sentence.find("supply:nosuch cannot be read") != std::string::npos) ++warnings;
  };
  run_recorder(stop.get_token(), options);
  EXPECT_EQ(warnings, 1);
}

}  // namespace
}  // namespace roadbalance
