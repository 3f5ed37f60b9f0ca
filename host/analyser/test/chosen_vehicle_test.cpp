#include "host/analyser/chosen_vehicle.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <string>

#include "common/test/temporary_directory.hpp"
#include "common/types/text_crc.hpp"
#include "host/analyser/test/noise_drive.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;

class Chosen : public testing::Test {
 protected:
  Chosen() {
    write("first.toml", first_.text);
    write("notes.toml", "this is no vehicle");
    write("second.toml", second_text_);
  }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
  }
  ChosenVehicle chosen() {
    return {first_, vehicle_files_in(folder_.path()),
            [this](const std::string& warning) { warning_ += warning; }};
  }
  static NodeSetup setup(int node, const std::string& text) {
    NodeSetup setup;
    setup.node = node;
    setup.vehicle_crc32c = crc32c(text);
    return setup;
  }

  test::TemporaryDirectory folder_;
  const VehicleConfig first_ = test::car();
  const std::string second_text_ = first_.text + "\n# of another day\n";
  std::string warning_;
  WallTime now_ = WallTime{} + 100s;
};

TEST_F(Chosen, IsWhatAllNodesSayOnce) {
  ChosenVehicle vehicle = chosen();
  EXPECT_FALSE(vehicle.changed(now_)) << "nobody has said anything";
  vehicle.take(setup(1, first_.text), now_);
  vehicle.take(setup(2, first_.text), now_);
  EXPECT_FALSE(vehicle.changed(now_));
  vehicle.take(setup(1, second_text_), now_ += 2s);
  EXPECT_FALSE(vehicle.changed(now_)) << "node 2 measures by the first";
  vehicle.take(setup(2, second_text_), now_);
  const auto now = vehicle.changed(now_ += 2s);
  ASSERT_TRUE(now);
  EXPECT_EQ(now->text, second_text_);
  vehicle.take(setup(1, second_text_), now_ += 2s);
  EXPECT_FALSE(vehicle.changed(now_)) << "told already";
}

TEST_F(Chosen, IsLookedForAgainUntilItsFileIsThere) {
  const std::string third = first_.text + "\n# written when the nodes have it\n";
  ChosenVehicle vehicle = chosen();
  vehicle.take(setup(1, third), now_);
  EXPECT_FALSE(vehicle.changed(now_));
  EXPECT_NE(warning_.find("vehicle.toml"), std::string::npos);
  warning_.clear();
  write("third.toml", third);
  vehicle.take(setup(1, third), now_ += 2s);
  ASSERT_TRUE(vehicle.changed(now_));
  EXPECT_EQ(warning_, "");
}

TEST_F(Chosen, WhoIsSilentHasNoSay) {
  ChosenVehicle vehicle = chosen();
  vehicle.take(setup(1, first_.text), now_);
  vehicle.take(setup(2, second_text_), now_ += 4s);
  EXPECT_TRUE(vehicle.changed(now_));
}

}  // namespace
}  // namespace roadbalance
