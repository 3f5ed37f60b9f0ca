#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "firmware/backends/socketcan/can_intake.hpp"
#include "firmware/device_diary.hpp"
#include "hil_tests/guest/can_player.hpp"
#include "hil_tests/guest/serial_can.hpp"
#include "hil_tests/program.hpp"

namespace roadbalance {
namespace {

using test::ip;
using test::SerialCan;
using test::wait_until;

/// The controller's state by the kernel, e.g. "BUS-OFF".
std::string state_of(const std::string& interface) {
  const std::unique_ptr<FILE, int (*)(FILE*)> answer(
      ::popen(("ip -details link show " + interface).c_str(), "r"), ::pclose);
  std::string text;
  for (int c = 0; answer && (c = std::fgetc(answer.get())) != EOF;) text += static_cast<char>(c);
  const auto begin = text.find("state ", text.find("can "));
  return begin == std::string::npos ? text : text.substr(begin + 6, text.find(' ', begin + 6) - begin - 6);
}

class BusOffTest : public testing::Test {
 protected:
  void SetUp() override {
    ip("link set " + can.interface() + " type can bitrate 500000");
    ip("link set " + can.interface() + " up");
    intake = std::make_unique<CanIntake>(can.interface(), CanNeed{.role = CanRole::kSensor},
                                         std::vector<CanId>{{0x100, false}}, [](const std::string&) {});
  }
  void TearDown() override {
    intake.reset();
    ip("link set " + can.interface() + " down");
  }
  bool counts(DeviceCounter counter, std::int64_t times) const {
    return wait_until([&] { return intake->report().of(counter) == times; }, 10);
  }
  SerialCan can;
  std::unique_ptr<CanIntake> intake;
};

TEST_F(BusOffTest, IsCountedWhenTheKernelSaysBusOffAndOverWhenTheInterfaceIsRestarted) {
  can.report("t1002AABB");
  ASSERT_TRUE(wait_until([&] { return intake->front() != nullptr; }, 10));
  EXPECT_EQ(intake->front()->frame.data[1], 0xBB);
  intake->pop();
  EXPECT_EQ(state_of(can.interface()), "ERROR-ACTIVE");
  can.report("sp130130");
  EXPECT_TRUE(counts(DeviceCounter::kErrorPassive, 1));
  EXPECT_EQ(state_of(can.interface()), "ERROR-PASSIVE");
  can.report("sb256256");
  EXPECT_TRUE(counts(DeviceCounter::kBusOff, 1));
  EXPECT_EQ(state_of(can.interface()), "BUS-OFF");
  EXPECT_EQ(intake->report().of(DeviceCounter::kGone), 0);
  std::vector<std::string> said;
  DeviceDiary({&intake->report()}).look([&](const std::string& sentence) { said.push_back(sentence); });
  const std::string name = "can:" + can.interface();
  EXPECT_EQ(said, (std::vector{
                      name + ": bus-off: the controller no longer takes part in the bus (1 time by now)",
                      name + ": error-passive: the controller sees many errors on the bus (1 time by now)"}));

  // slcan cannot restart its controller; down and up does.
  ip("link set " + can.interface() + " down");
  EXPECT_TRUE(counts(DeviceCounter::kGone, 1));
  ip("link set " + can.interface() + " up");
  EXPECT_TRUE(counts(DeviceCounter::kReturned, 1));
  EXPECT_EQ(state_of(can.interface()), "ERROR-ACTIVE");
  can.report("t1002CCDD");
  ASSERT_TRUE(wait_until([&] { return intake->front() != nullptr; }, 10));
  EXPECT_TRUE(intake->front()->after_absence);
}

TEST_F(BusOffTest, CountsErrorsOnTheBusAndTheControllersOverrun) {
  can.report("e1a");  // acknowledge missing
  EXPECT_TRUE(counts(DeviceCounter::kBusErrors, 1));
  can.report("e1o");
  EXPECT_TRUE(counts(DeviceCounter::kControllerOverrun, 1));
}

TEST_F(BusOffTest, TellsTheAdapterNothingWhileTheNodeListens) {
  // Opened it is when the interface comes up.
  ASSERT_TRUE(wait_until([&] { return can.told().ends_with("O|"); }, 10)) << can.told();
  const std::string before = can.told();
  for (int k = 0; k < 20; ++k) can.report("t1002AABB");
  int heard = 0;
  const auto all_are_heard = [&] {
    for (; intake->front(); intake->pop()) ++heard;
    return heard == 20;
  };
  ASSERT_TRUE(wait_until(all_are_heard, 10));
  // All earlier commands come before the one that closes it.
  ip("link set " + can.interface() + " down");
  ASSERT_TRUE(wait_until([&] { return can.told().ends_with("C|") && can.told() != before; }, 10))
      << can.told();
  EXPECT_EQ(can.told(), before + "C|");
}

}  // namespace
}  // namespace roadbalance
