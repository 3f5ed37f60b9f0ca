#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "hil_tests/players/usb_board/test/board_watch.hpp"

namespace roadbalance::test {

/// One board, plugged into the kernel by the test, opened as a node does and watched.
class UsbBoardFixture : public testing::Test {
 protected:
  explicit UsbBoardFixture(const Bench& bench = numbered_bench("BENCH1", 30.0)) : boards({bench}) {}

  void open(AlsoLooks also = {}) {
    front_end = open_when_enumerated({"1209:0001", car, car.node[0]}, [this](const std::string& text) {
      const std::scoped_lock lock(saying_);
      if (text.find("starting it again") != std::string::npos) reported_.push_back(text);
    });
    watch = std::make_unique<BoardWatch>(*front_end, car, std::move(also));
  }
  std::int64_t count(DeviceCounter counter) const { return front_end->reports()[0]->of(counter); }
  /// Every counter but these is 0.
  void expect_only(const std::vector<DeviceCounter>& counters) const {
    for (std::size_t k = 0; k < kDeviceCounters; ++k) {
      const auto counter = static_cast<DeviceCounter>(k);
      const bool expected = std::ranges::find(counters, counter) != counters.end();
      EXPECT_TRUE(expected || count(counter) == 0) << sentence(counter) << " " << count(counter);
    }
  }

  /// The sentences about boards that are started again.
  std::vector<std::string> said() {
    const std::scoped_lock lock(saying_);
    return reported_;
  }

 private:
  std::mutex saying_;  // both outlive the front end's thread
  std::vector<std::string> reported_;

 protected:
  VehicleConfig car = board_vehicle();
  UsbBoards boards;
  std::unique_ptr<FrontEnd> front_end;
  std::unique_ptr<BoardWatch> watch;
};

}  // namespace roadbalance::test
