#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <string>

#include "hil_tests/players/usb_board/test/board_watch.hpp"

namespace roadbalance {
namespace {

using test::BoardWatch;
using test::numbered_bench;
using test::open_when_enumerated;
using test::UsbBoards;

constexpr int kNobody = 65534;

std::string refusal(const std::string& address, const VehicleConfig& car) {
  try {
    open_usb_front_end({address, car, car.node[0]}, [](const std::string&) {});
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

/// The text that is printed once the kernel has enumerated the board.
std::string lasting_refusal(const std::string& address, const VehicleConfig& car) {
  std::string text;
  test::wait_until(
      [&] { return (text = refusal(address, car)).find("is plugged in; there is") == std::string::npos; },
      5.0);
  std::printf("%s\n", text.c_str());
  return text;
}

std::string told_by_another_process(const std::function<std::string()>& tell) {
  int ends[2];
  if (::pipe(ends) != 0) return "no pipe";
  const pid_t child = ::fork();
  if (child == 0) {
    const std::string text = tell();
    ::_exit(::write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()) ? 0 : 1);
  }
  ::close(ends[1]);
  std::array<char, 1000> text{};
  const ssize_t size = ::read(ends[0], text.data(), text.size());
  ::close(ends[0]);
  ::waitpid(child, nullptr, 0);
  return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "";
}

TEST(UsbBoards, RefusalsNameWhatIsAtFault) {
  const VehicleConfig car = test::board_vehicle();
  UsbBoards boards({numbered_bench("BENCH1")});
  EXPECT_NE(refusal("dead:beef", car).find("no device dead:beef is plugged in; there is: 1d6b:"),
            std::string::npos);
  boards.plug();
  VehicleConfig other = car;
  other.filter.order = 5;
  EXPECT_NE(lasting_refusal("1209:0001", other).find("filter: order: 5"), std::string::npos);
  EXPECT_NE(lasting_refusal("1209:0001:NOBODY", car).find("BENCH1"), std::string::npos);

  std::string denied;
  // User and groups of this thread only; the C library would change those of all threads.
  std::thread([&] {
    ::syscall(SYS_setgroups, 0, nullptr);
    ::syscall(SYS_setresgid, -1, kNobody, -1);
    ::syscall(SYS_setresuid, -1, kNobody, -1);
    denied = lasting_refusal("1209:0001", car);
  }).join();
  EXPECT_NE(denied.find("no permission for /dev/bus/usb/"), std::string::npos);
  EXPECT_NE(
      denied.find("SUBSYSTEM==\"usb\", ATTR{idVendor}==\"1209\", ATTR{idProduct}==\"0001\", MODE=\"0660\""),
      std::string::npos);

  const auto front_end = open_when_enumerated({"1209:0001", car, car.node[0]});
  const std::string busy = told_by_another_process([&] { return lasting_refusal("1209:0001", car); });
  std::string name;
  std::getline(std::ifstream("/proc/self/comm"), name);
  ASSERT_FALSE(name.empty());
  EXPECT_NE(busy.find("is in use by " + name + " (process " + std::to_string(::getpid()) + ")"),
            std::string::npos)
      << busy;
}

TEST(UsbBoards, FirmwareOfAnotherMajorVersionIsRefusedNamingBoth) {
  const VehicleConfig car = test::board_vehicle();
  test::Bench bench = numbered_bench("FUTURE");
  bench.major = 2;
  UsbBoards boards({bench});
  boards.plug();
  const std::string text = lasting_refusal("1209:0001:FUTURE", car);
  EXPECT_NE(text.find("the board speaks protocol 2.0, this node 1.0"), std::string::npos);
}

TEST(UsbBoards, FirmwareOfAnOlderMajorVersionIsRefusedNamingBoth) {
  const VehicleConfig car = test::board_vehicle();
  test::Bench bench = numbered_bench("PAST");
  bench.major = 0;
  UsbBoards boards({bench});
  boards.plug();
  const std::string text = lasting_refusal("1209:0001:PAST", car);
  EXPECT_NE(
      text.find("usb:1209:0001:PAST: the board speaks protocol 0.0, this node 1.0; newer firmware of the "
                "board is needed"),
      std::string::npos);
}

TEST(UsbBoards, ABoardWithoutASerialNumberIsSaidToBeThere) {
  const VehicleConfig car = test::board_vehicle();
  UsbBoards boards({numbered_bench("")});
  boards.plug();
  EXPECT_NE(lasting_refusal("1209:0001:A17", car)
                .find("no device 1209:0001 has this serial number; there is: one without"),
            std::string::npos);
}

TEST(UsbBoards, FirmwareOfANewerMinorVersionWorks) {
  const VehicleConfig car = test::board_vehicle();
  test::Bench bench = numbered_bench("NEWER");
  bench.minor = 4;
  UsbBoards boards({bench});
  boards.plug();
  std::string warned;
  const auto front_end =
      open_when_enumerated({"1209:0001", car, car.node[0]}, [&](const std::string& text) { warned = text; });
  BoardWatch watch(*front_end, car);
  EXPECT_TRUE(watch.more_scans(2000));
  watch.end();
  EXPECT_NE(warned.find("the board speaks protocol 1.4, this node 1.0"), std::string::npos);
  EXPECT_EQ(watch.wrong_scans(), 0);
  EXPECT_EQ(watch.jumps().size(), 0u);
}

TEST(UsbBoards, TwoStayTogetherAndReturnTogether) {
  const VehicleConfig car = test::board_vehicle();
  UsbBoards boards({test::timed_bench("MASTER", 60.0), test::timed_bench("SECOND", -60.0)});
  boards.plug(0);
  boards.plug(1);
  std::int64_t apart = 0;
  const auto front_end = open_when_enumerated({"1209:0001:MASTER+SECOND", car, car.node[0]});
  {
    // Number and instant of the conversion, at six inputs of either board.
    const auto compare = [&](const Scan& scan) {
      for (std::size_t c = 0; c < 6; ++c)
        if (scan.counts[6 + c] != scan.counts[c]) ++apart;
    };
    BoardWatch watch(*front_end, car, {.scan = compare, .edge = {}, .inputs = 1});
    EXPECT_TRUE(watch.more_scans(20'000));
    boards.unplug(1);
    boards.plug(1);
    EXPECT_TRUE(watch.more_scans(5000));
    watch.end();
    EXPECT_EQ(watch.wrong_scans(), 0);
    ASSERT_EQ(watch.gaps().size(), 1u);
    EXPECT_EQ(watch.gaps()[0].cause, GapCause::kDeviceGone);
  }
  EXPECT_EQ(apart, 0);
  EXPECT_EQ(front_end->reports()[1]->of(DeviceCounter::kGone), 1);
  EXPECT_EQ(front_end->reports()[1]->of(DeviceCounter::kReturned), 1);
  for (std::size_t k = 0; k < kDeviceCounters; ++k)
    EXPECT_EQ(front_end->reports()[0]->of(DeviceCounter(k)), 0) << sentence(DeviceCounter(k));
}

}  // namespace
}  // namespace roadbalance
