#include "common/record/room.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "common/record/test/simulated_disk.hpp"

namespace roadbalance {
namespace {

TEST(Room, RefusesWhatDoesNotFitWithBothFigures) {
  test::SimulatedDisk disk;
  disk.set_capacity(2'100'000);
  expect_room("/", 2'100'000, disk);
  try {
    expect_room("/", 9'340'000'000, disk);
    FAIL() << "it does not fit";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()),
              "/: at least 9.3 GB are to go there, 2.1 MB are free: make room on its disk, and begin again");
  }
}

TEST(Room, TellsBytesAsDisksAreSold) {
  EXPECT_EQ(bytes_text(0), "0.0 MB");
  EXPECT_EQ(bytes_text(999'949'999), "999.9 MB");
  EXPECT_EQ(bytes_text(1'000'000'000), "1.0 GB");
}

}  // namespace
}  // namespace roadbalance
