#include "tools/rb/machine.hpp"

#include <gtest/gtest.h>
#include <cerrno>

#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

constexpr const char* kHeader =
    "Iface\tDestination\tGateway \tFlags\tRefCnt\tUse\tMetric\tMask\t\tMTU\tWindow\tIRTT\n";

TEST(MulticastRoute, IsMissingOnALaptopWithoutNetwork) {
  EXPECT_FALSE(has_multicast_route(""));
  EXPECT_FALSE(has_multicast_route(kHeader));
  // 192.168.1.0/24 alone leads nowhere for 224.0.0.0/4.
  EXPECT_FALSE(has_multicast_route(std::string(kHeader) +
                                   "eth0\t0001A8C0\t00000000\t0001\t0\t0\t0\t00FFFFFF\t0\t0\t0\n"));
  const Finding finding = multicast_route(kHeader);
  EXPECT_EQ(finding.state, Finding::kIll);
  EXPECT_NE(finding.remedy.find("ip route add 224.0.0.0/4 dev lo"), std::string::npos);
}

TEST(MulticastRoute, IsTheDefaultRouteOrItsOwn) {
  EXPECT_TRUE(has_multicast_route(std::string(kHeader) +
                                  "eth0\t00000000\t010011AC\t0003\t0\t0\t0\t00000000\t0\t0\t0\n"));
  EXPECT_TRUE(has_multicast_route(std::string(kHeader) +
                                  "lo\t000000E0\t00000000\t0001\t0\t0\t0\t000000F0\t0\t0\t0\n"));
  // Every route that holds the group will do, of whatever length.
  for (const char* route : {"000000EF\t00000000\t0001\t0\t0\t0\t000000FF",
                            "0000FFEF\t0\t1\t0\t0\t0\t0000FFFF", "434CFFEF\t0\t1\t0\t0\t0\tFFFFFFFF"})
    EXPECT_TRUE(has_multicast_route(std::string(kHeader) + "eth0\t" + route + "\t0\t0\t0\n")) << route;
  EXPECT_FALSE(
      has_multicast_route(std::string(kHeader) + "eth0\t0000FEEF\t0\t1\t0\t0\t0\t0000FFFF\t0\t0\t0\n"));
  EXPECT_EQ(multicast_route(std::string(kHeader) + "lo\t000000E0\t0\t1\t0\t0\t0\t000000F0\t0\t0\t0\n").state,
            Finding::kWell);
}

TEST(ReceiveBuffer, IsEnoughFromFourMebibytesOn) {
  EXPECT_EQ(receive_buffer(4'194'304).state, Finding::kWell);
  const Finding finding = receive_buffer(212'992);
  EXPECT_EQ(finding.state, Finding::kNote);
  EXPECT_EQ(finding.remedy, "sudo sysctl -w net.core.rmem_max=4194304");
}

TEST(WritableFolder, LooksAtWhereTheFolderWouldBeCreated) {
  EXPECT_EQ(writable_folder("not/there/yet").state, Finding::kWell);
  EXPECT_EQ(writable_folder("/proc/not/there").state, Finding::kIll);
}

// A remedy must not take a folder from its owner.
TEST(WritableFolder, IsMendedWithANewFolderThatChangesNoOther) {
  EXPECT_EQ(unwritable_folder("/srv/my car's drives", "/srv", EACCES).remedy,
            "sudo install -d -o \"$USER\" '/srv/my car'\\''s drives'");
  EXPECT_EQ(unwritable_folder("/", "/", EACCES).remedy, "sudo install -d -o \"$USER\" '/recordings'");
}

TEST(WritableFolder, SaysWhatNoOwnerCanMend) {
  const Finding full = unwritable_folder("drives", "/srv", ENOSPC);
  EXPECT_NE(full.sentence.find("No space left on device"), std::string::npos) << full.sentence;
  EXPECT_EQ(full.remedy.find("install"), std::string::npos);
  const Finding fixed = unwritable_folder("drives", "/srv", EROFS);
  EXPECT_NE(fixed.sentence.find("Read-only file system"), std::string::npos) << fixed.sentence;
  EXPECT_EQ(fixed.remedy.find("install"), std::string::npos);
}

// One edge per wake-up of the interrupt thread, sixteen per wake-up of the reader; the ring needs
// 96 * 250 / 3.6 / (2 pi 0.3) = 3537 Hz.
TEST(EncoderEdges, AreSafeUpToWhatTheWorstWakeUpAllows) {
  using std::chrono::microseconds;
  const Finding well =
      encoder_edges({.worst = {.interrupt_thread = microseconds(50), .reader = microseconds(800)},
                     .duration = std::chrono::seconds(30),
                     .realtime = true});
  EXPECT_EQ(well.state, Finding::kWell);
  EXPECT_NE(
      well.sentence.find("in 30 s threads woke up 0.05 ms late at worst where the kernel takes edges one "
                         "by one, 0.80 ms where a node takes up to 16: up to 20.0 kHz"),
      std::string::npos)
      << well.sentence;
  EXPECT_NE(well.sentence.find("needs 3.5 kHz"), std::string::npos) << well.sentence;

  const Finding slow =
      encoder_edges({.worst = {.interrupt_thread = microseconds(400), .reader = microseconds(50)},
                     .duration = {},
                     .realtime = true});
  EXPECT_EQ(slow.state, Finding::kNote);
  EXPECT_NE(slow.sentence.find("up to 2.5 kHz"), std::string::npos) << slow.sentence;
  EXPECT_NE(slow.remedy.find("linux-image-rt"), std::string::npos) << slow.remedy;
  const Finding ordinary =
      encoder_edges({.worst = {.interrupt_thread = microseconds(400), .reader = microseconds(50)},
                     .duration = {},
                     .realtime = false});
  EXPECT_NE(ordinary.remedy.find("rtprio"), std::string::npos) << ordinary.remedy;
}

TEST(EncoderEdges, WakeUpsAreMeasured) {
  const WakeUpMeasurement measured = measure_wake_ups(std::chrono::milliseconds(50));
  EXPECT_GT(measured.worst.interrupt_thread.count(), 0);
  EXPECT_GT(measured.worst.reader.count(), 0);
  EXPECT_EQ(measured.duration, std::chrono::milliseconds(50));
}

TEST(WallClock, IsKeptRightOrDatesAreDoubtful) {
  EXPECT_EQ(wall_clock(true).state, Finding::kWell);
  EXPECT_EQ(wall_clock(false).state, Finding::kNote);
  EXPECT_NE(wall_clock(false).sentence.find("dates"), std::string::npos);
}

// 3 * 16 * 2000 * 4 bytes a second: 11.06 GB are 8 h.
TEST(Disk, HasRoomForALongDriveAndIsFast) {
  using std::chrono::milliseconds;
  const Finding well = disk("drives", {.free_bytes = 110'592'000'000, .worst_sync = milliseconds(20)});
  EXPECT_EQ(well.state, Finding::kWell);
  EXPECT_NE(well.sentence.find("room for 80 h"), std::string::npos) << well.sentence;
  EXPECT_NE(well.sentence.find("20.0 ms at worst"), std::string::npos) << well.sentence;
  const Finding full = disk("drives", {.free_bytes = 11'000'000'000, .worst_sync = {}});
  EXPECT_EQ(full.state, Finding::kNote);
  EXPECT_NE(full.remedy.find("rb transfer"), std::string::npos) << full.remedy;
  const Finding slow = disk("drives", {.free_bytes = 110'592'000'000, .worst_sync = milliseconds(400)});
  EXPECT_EQ(slow.state, Finding::kNote);
}

TEST(Disk, IsMeasuredWhereItIsAndLeavesNothing) {
  const test::TemporaryDirectory directory;
  // Others may write between the two looks, but not each time.
  DiskMeasurement measured;
  std::uintmax_t available = 0;
  for (int attempt = 0; attempt == 0 || (measured.free_bytes != available && attempt < 100); ++attempt) {
    available = std::filesystem::space(directory.path()).available;
    measured = measure_disk(directory.path() / "not" / "there");
  }
  EXPECT_EQ(measured.free_bytes, available);
  EXPECT_GT(measured.worst_sync.count(), 0.0);
  EXPECT_TRUE(std::filesystem::is_empty(directory.path()));
}

}  // namespace
}  // namespace roadbalance
