#include "tools/doctor/recording_folder.hpp"

#include <gtest/gtest.h>
#include <linux/magic.h>

#include <cerrno>

#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

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

// Data that a disk calls stored must survive a power cut or a network failure.
TEST(FileSystem, IsNamedWhereItMayLoseWhatWasPromised) {
  for (const std::int64_t kind : {0xEF53L /* ext4 */, 0x58465342L /* xfs */, 0x9123683EL /* btrfs */})
    EXPECT_FALSE(file_system("drives", kind));
  const auto said = [](std::int64_t kind) {
    const auto finding = file_system("drives", kind);
    if (!finding) return std::string();
    EXPECT_EQ(finding->state, Finding::kNote);
    EXPECT_NE(finding->remedy.find("rb doctor --folder"), std::string::npos);
    return finding->sentence;
  };
  EXPECT_NE(said(TMPFS_MAGIC).find("in memory"), std::string::npos);
  EXPECT_NE(said(MSDOS_SUPER_MAGIC).find("FAT"), std::string::npos);
  EXPECT_NE(said(NFS_SUPER_MAGIC).find("another machine"), std::string::npos);
  EXPECT_NE(said(0xFE534D42L /* smb2 */).find("another machine"), std::string::npos);
}

// 3 * 16 * 2000 * 4 bytes a second, and a block of 20 scans is 1395 bytes in the log instead of 1280: 12.05
// GB are 8 h.
TEST(Disk, HasRoomForALongDriveAndIsFast) {
  using std::chrono::milliseconds;
  const Finding well =
      disk("drives", {.free_bytes = 120'528'000'000, .worst_sync = milliseconds(20)}, ordinary_rate());
  EXPECT_EQ(well.state, Finding::kWell);
  EXPECT_NE(well.sentence.find("room for 80 h"), std::string::npos) << well.sentence;
  EXPECT_NE(well.sentence.find("20.0 ms at worst"), std::string::npos) << well.sentence;
  const Finding full = disk("drives", {.free_bytes = 12'000'000'000, .worst_sync = {}}, ordinary_rate());
  EXPECT_EQ(full.state, Finding::kNote);
  EXPECT_NE(full.remedy.find("rb transfer"), std::string::npos) << full.remedy;
  const Finding slow =
      disk("drives", {.free_bytes = 120'528'000'000, .worst_sync = milliseconds(400)}, ordinary_rate());
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

// The demonstration car: two nodes of 16 channels at 2 kHz, 2 * 16 * 2000 * 4 * 1395 / 1280 bytes a second,
// and four rings of 96 at 130 km/h and 0.3 m, 4 * 96 * 19.16 edges of 3 bytes: 301 kB/s.
TEST(RecordingRate, IsOfTheVehicleThatIsDriven) {
  const auto car = VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "vehicle.toml");
  const RecordingRate rate = rate_of(car);
  EXPECT_NEAR(rate.bytes_s, 278'999 + 22'069, 100);
  const Finding well = disk("drives", {.free_bytes = 10'838'000'000, .worst_sync = {}}, rate);
  EXPECT_NE(well.sentence.find("room for 10 h of \"demonstration car\""), std::string::npos) << well.sentence;
}

}  // namespace
}  // namespace roadbalance
