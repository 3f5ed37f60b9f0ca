#include "firmware/backends/socketcan/can_socket.hpp"

#include <gtest/gtest.h>
#include <linux/can/error.h>

#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "common/test/no_allocation.hpp"
#include "firmware/backends/socketcan/can_intake.hpp"
#include "hil_tests/guest/can_player.hpp"
#include "hil_tests/program.hpp"

namespace roadbalance {
namespace {

using Kind = CanReceived::Kind;
using test::CanPlayer;
using test::VirtualCan;

const std::vector<CanId> kWanted{{0x123, false}, {0x123, true}};

CanFrame numbered(std::uint32_t number) {
  CanFrame frame{.id = 0x123, .size = 8};
  std::memcpy(frame.data.data(), &number, sizeof number);
  return frame;
}

/// A setting of the kernel, until the end of its life.
class KernelSetting {
 public:
  KernelSetting(const std::string& name, const std::string& value) : path_("/proc/sys/" + name) {
    std::ifstream(path_) >> before_;
    set(value);
  }
  KernelSetting(const KernelSetting&) = delete;
  KernelSetting& operator=(const KernelSetting&) = delete;
  ~KernelSetting() { set(before_); }

 private:
  void set(const std::string& value) const {
    EXPECT_TRUE((std::ofstream(path_) << value << std::flush).good()) << path_;
  }
  std::string path_, before_;
};

/// The next frame or trouble, waiting for it.
CanReceived next(CanSocket& socket) {
  CanReceived received;
  for (int tries = 0; tries < 100; ++tries) {
    received = socket.receive();
    if (received.kind != Kind::kNothing && received.kind != Kind::kIgnored) return received;
    socket.wait(std::chrono::milliseconds(20));
  }
  return received;
}

/// How many frames come until none has for a while: what was sent may still be on its way through the kernel.
std::uint64_t frames_of(CanSocket& socket) {
  std::uint64_t frames = 0;
  for (int silent = 0; silent < 5;) {
    if (socket.receive().kind == Kind::kFrame) {
      ++frames;
      silent = 0;
    } else {
      ++silent;
      socket.wait(std::chrono::milliseconds(20));
    }
  }
  return frames;
}

TEST(CanSocket, ReceivesFramesOfCanFdAndOnlyThoseItWants) {
  const VirtualCan can("vcan7");
  CanSocket socket(can.name(), kWanted);
  CanPlayer player(can.name());
  CanFrame longest{.id = 0x123, .is_fd = true, .size = 64};
  for (std::size_t k = 0; k < 64; ++k) longest.data[k] = static_cast<std::uint8_t>(3 * k);
  player.send({.id = 0x124, .size = 8});
  player.send(longest);
  player.send({.id = 0x124, .extended = true, .size = 8});
  player.send({.id = 0x123, .extended = true, .size = 3});
  const CanReceived first = next(socket);
  ASSERT_EQ(first.kind, Kind::kFrame);
  EXPECT_TRUE(first.frame.is_fd);
  EXPECT_EQ(first.frame.size, 64);
  EXPECT_EQ(first.frame.data, longest.data);
  const CanReceived second = next(socket);
  ASSERT_EQ(second.kind, Kind::kFrame);
  EXPECT_TRUE(second.frame.extended);
  EXPECT_FALSE(second.frame.is_fd);
  EXPECT_EQ(second.frame.size, 3);
  EXPECT_GE(second.time, first.time);
  EXPECT_EQ(socket.receive().kind, Kind::kNothing);
}

TEST(CanSocket, StampsInTheMachinesTimeWhenTheFrameCameNotWhenItWasRead) {
  const VirtualCan can("vcan7");
  CanSocket socket(can.name(), kWanted);
  CanPlayer player(can.name());
  ASSERT_FALSE(test::wait_until([] { return false; }, 0.05));  // until the kernel stamps what comes
  std::vector<MachineTime> before, after;
  for (std::uint32_t k = 0; k < 50; ++k) {
    before.push_back(MachineClock::now());
    player.send(numbered(k));
    after.push_back(MachineClock::now());
  }
  ASSERT_FALSE(test::wait_until([] { return false; }, 0.05));  // the frames wait
  for (std::uint32_t k = 0; k < 50; ++k) {
    const CanReceived received = next(socket);
    ASSERT_EQ(received.kind, Kind::kFrame);
    // Sending on a virtual interface is receiving; 1 us is what the pair of clocks is known to.
    EXPECT_GE(received.time, before[k] - std::chrono::microseconds(1));
    EXPECT_LE(received.time, after[k] + std::chrono::microseconds(1));
  }
}

TEST(CanSocket, CountsWhatTheKernelHadNoRoomForToTheFrame) {
  const VirtualCan can("vcan7");
  CanSocket socket(can.name(), kWanted);
  CanPlayer player(can.name());
  constexpr std::uint32_t kSent = 60'000;
  for (std::uint32_t k = 0; k < kSent; ++k) player.send(numbered(k));
  const test::NoAllocation guard;
  const std::uint64_t received = frames_of(socket);
  const std::uint64_t lost = socket.take_lost();
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(lost, 0U);
  EXPECT_GT(received, 8'000U);  // a second of a full bus
  EXPECT_EQ(received + lost, kSent);
  player.send(numbered(0));
  EXPECT_EQ(next(socket).kind, Kind::kFrame);
  EXPECT_EQ(socket.take_lost(), 0U);
  std::printf("of %u frames against a stopped reader %ju received, %ju counted as lost\n", kSent,
              static_cast<std::uintmax_t>(received), static_cast<std::uintmax_t>(lost));
}

// Before the socket, frames of all interfaces wait in a queue of the processor.  Here that has room for one,
// and the frames of 20 ms come at once.
TEST(CanSocket, CountsWhatTheQueueBeforeItHadNoRoomFor) {
  const KernelSetting room("net/core/netdev_max_backlog", "1");
  const test::VirtualCan can("vcan7", "vcan8");
  ASSERT_EQ(test::run("tc", {"qdisc", "add", "dev", "vcan8", "root", "netem", "slot", "20ms"}, 30), 0);
  CanSocket socket(can.name(), kWanted);
  CanPlayer player("vcan8");
  constexpr std::uint32_t kSent = 500;
  for (std::uint32_t k = 0; k < kSent; ++k) player.send(numbered(k));
  const std::uint64_t received = frames_of(socket);
  const std::uint64_t lost = socket.take_lost();
  EXPECT_GT(received, 0U);
  EXPECT_GT(lost, 0U);
  EXPECT_EQ(received + lost, kSent);
  EXPECT_EQ(socket.take_lost(), 0U);
}

TEST(CanSocket, TellsTheControllersTroublesApart) {
  const VirtualCan can("vcan7");
  CanSocket socket(can.name(), kWanted);
  CanPlayer player(can.name());
  const auto trouble = [&](std::uint32_t error, std::uint8_t controller = 0) {
    player.send_error(error, controller);
    const CanReceived received = next(socket);
    EXPECT_EQ(received.kind, Kind::kTrouble);
    return received.trouble;
  };
  EXPECT_EQ(trouble(CAN_ERR_BUSOFF), DeviceCounter::kBusOff);
  EXPECT_EQ(trouble(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_PASSIVE), DeviceCounter::kErrorPassive);
  EXPECT_EQ(trouble(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE), DeviceCounter::kErrorPassive);
  EXPECT_EQ(trouble(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW), DeviceCounter::kControllerOverrun);
  EXPECT_EQ(trouble(CAN_ERR_CRTL | CAN_ERR_PROT, CAN_ERR_CRTL_RX_WARNING), DeviceCounter::kBusErrors);
  EXPECT_EQ(trouble(CAN_ERR_PROT | CAN_ERR_BUSERROR), DeviceCounter::kBusErrors);
  // The controller's state alone is no trouble.
  player.send_error(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_WARNING);
  player.send_error(CAN_ERR_CRTL | CAN_ERR_CNT, CAN_ERR_CRTL_TX_WARNING);
  player.send_error(CAN_ERR_RESTARTED);
  player.send_error(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE);
  player.send(numbered(1));
  EXPECT_EQ(next(socket).kind, Kind::kFrame);
}

TEST(CanIntake, CountsTroublesAndFramesThatItsReaderDoesNotFetch) {
  const VirtualCan can("vcan7");
  CanIntake intake(can.name(), {.role = CanRole::kVehicle}, kWanted, [](const std::string&) {});
  CanPlayer player(can.name());
  player.send_error(CAN_ERR_BUSOFF);
  for (std::uint32_t k = 0; k < 20'000; ++k) player.send(numbered(k));
  const auto of = [&](DeviceCounter counter) { return intake.report().of(counter); };
  const auto lost = [&] { return of(DeviceCounter::kReadersTooSlow) + of(DeviceCounter::kQueueOverflow); };
  EXPECT_TRUE(test::wait_until([&] { return of(DeviceCounter::kReadersTooSlow) > 0; }, 20));  // it is full
  EXPECT_EQ(of(DeviceCounter::kBusOff), 1);
  std::uint32_t number = 0;
  ASSERT_NE(intake.front(), nullptr);
  std::memcpy(&number, intake.front()->frame.data.data(), sizeof number);
  EXPECT_EQ(number, 0U);  // the oldest are kept
  // The rest may still be on its way through the kernel.
  std::int64_t held = 0;
  const auto all_are_told = [&] {
    for (; intake.front(); intake.pop()) ++held;
    return held + lost() == 20'000;
  };
  EXPECT_TRUE(test::wait_until(all_are_told, 20)) << held << " + " << lost();
}

}  // namespace
}  // namespace roadbalance
