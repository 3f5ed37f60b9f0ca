#include "host/recording/transfer/transfer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <random>

#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

using test::DiskCall;
using test::SimulatedDisk;
using testing::HasSubstr;

std::vector<std::uint8_t> noise(std::size_t bytes, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<std::uint8_t> noise(bytes);
  for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
  return noise;
}

/// A recording's files; the transfer uses only their names and bytes.
const std::map<std::string, std::vector<std::uint8_t>> kRecording{
    {"manifest.json", noise(700, 1)},           {"seg-000001.idx", {}},
    {"seg-000001.lcm", noise(2'500'000, 2)},    {"seg-000002.lcm", noise(1 << 20, 3)},
    {"seg-000002.lcm.tail-0", noise(1'234, 4)},
};

class TransferOfARecording : public testing::Test {
 protected:
  TransferOfARecording() {
    create_folders("/drives/monday", car_);
    for (const auto& [name, bytes] : kRecording) car_.put("/drives/monday/" + name, bytes);
    create_folders("/archive", far_);
    car_.set_read_only(true);  // the original is never altered
  }

  TransferReport transfer_to(SimulatedDisk& disk, const std::stop_token& stop = {},
                             const TransferProgress& progress = {}) {
    return transfer("/drives/monday", "/archive", stop, progress, car_, disk);
  }
  std::string refusal() {
    try {
      transfer_to(far_);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "nothing was refused";
  }
  void expect_equal(const SimulatedDisk& disk, const TransferReport& report) {
    for (const auto& [name, bytes] : kRecording)
      EXPECT_EQ(disk.content("/archive/monday/" + name), bytes) << name;
    ASSERT_EQ(report.file.size(), kRecording.size());
    EXPECT_EQ(report.to, "/archive/monday");
  }

  SimulatedDisk car_{1}, far_{2};
};

TEST_F(TransferOfARecording, IsEqualAndSaysSo) {
  std::uint64_t last = 0, all = 0;
  const TransferReport report = transfer_to(far_, {}, [&](std::uint64_t done, std::uint64_t of) {
    EXPECT_GE(done, last);
    last = done;
    all = of;
  });
  expect_equal(far_, report);
  EXPECT_EQ(report.resumed_bytes, 0u);
  EXPECT_FALSE(report.was_there);
  EXPECT_EQ(last, all);
  EXPECT_EQ(all, 2 * report.bytes);
  EXPECT_FALSE(path_exists("/archive/monday.part", far_));
  // Once more: nothing is written.
  far_.set_read_only(true);
  EXPECT_TRUE(transfer_to(far_).was_there);
}

// The disk loses power, or is unplugged, at any call; bytes that were not synced may be lost or torn.
TEST_F(TransferOfARecording, GoesOnAfterItWasInterruptedAtAnyInstant) {
  std::mt19937_64 random(7);
  std::uint64_t resumed = 0;
  for (int trial = 0; trial < 100; ++trial) {
    SimulatedDisk disk(static_cast<std::uint64_t>(100 + trial));
    create_folders("/archive", disk);
    bool arrived = false;
    for (int interruption = 0; !arrived && interruption < 4; ++interruption) {
      disk.set_fault(SimulatedDisk::at_call(disk.calls() + 1 + static_cast<std::int64_t>(random() % 40),
                                            {.error = EIO, .power_cut = true}));
      try {
        (void)transfer_to(disk);
        arrived = true;
      } catch (const std::runtime_error& error) {
        EXPECT_THAT(error.what(), HasSubstr("Input/output error"));
      }
      disk.power_on();
    }
    disk.set_fault({});
    const TransferReport report = transfer_to(disk);
    expect_equal(disk, report);
    resumed += report.resumed_bytes;
  }
  EXPECT_GT(resumed, 0u);
}

TEST_F(TransferOfARecording, GoesOnAfterItWasStoppedAtARandomByte) {
  std::mt19937_64 random(9);
  for (int trial = 0; trial < 20; ++trial) {
    SimulatedDisk disk(static_cast<std::uint64_t>(trial));
    create_folders("/archive", disk);
    std::stop_source stop;
    const std::uint64_t at = random() % 7'000'000;
    EXPECT_THROW(transfer_to(disk, stop.get_token(),
                             [&](std::uint64_t done, std::uint64_t) {
                               if (done >= at) stop.request_stop();
                             }),
                 std::runtime_error);
    EXPECT_FALSE(path_exists("/archive/monday", disk));
    expect_equal(disk, transfer_to(disk));
  }
}

TEST_F(TransferOfARecording, SaysWhichDiskIsGoneAndHowToGoOn) {
  far_.set_fault([](DiskCall call, std::int64_t, const std::string& path) {
    const bool gone = call == DiskCall::kWrite && path.ends_with("seg-000002.lcm");
    return SimulatedDisk::Outcome{.error = gone ? EIO : 0};
  });
  EXPECT_THAT(refusal(), testing::AllOf(HasSubstr("write /archive/monday.part/seg-000002.lcm: Input/output"),
                                        HasSubstr("the same command goes on")));
}

TEST_F(TransferOfARecording, RefusesWhatIsStillBeingRecorded) {
  File recorder = File::open_folder("/drives/monday", car_);
  ASSERT_TRUE(recorder.try_lock());
  EXPECT_THAT(refusal(), HasSubstr("/drives/monday: is being recorded"));
}

TEST_F(TransferOfARecording, RefusesADiskWithTooLittleSpaceBeforeItBegins) {
  far_.set_capacity(1'000'000);
  EXPECT_THAT(refusal(),
              testing::MatchesRegex("/archive: at least [0-9.]+ MB are to go there, 1.0 MB are free: .*"));
  EXPECT_EQ(far_.used_bytes(), 0);
}

TEST_F(TransferOfARecording, RefusesANameThatAnotherRecordingHas) {
  create_folders("/archive/monday", far_);
  far_.put("/archive/monday/seg-000001.lcm", noise(2'500'000, 5));
  EXPECT_THAT(refusal(), HasSubstr("/archive/monday: is there already"));
  EXPECT_EQ(far_.content("/archive/monday/seg-000001.lcm"), noise(2'500'000, 5));
}

TEST_F(TransferOfARecording, RefusesAPartOfAnotherRecording) {
  create_folders("/archive/monday.part", far_);
  far_.put("/archive/monday.part/seg-000009.lcm", noise(10, 5));
  EXPECT_THAT(refusal(), HasSubstr("/archive/monday.part/seg-000009.lcm: is not in /drives/monday"));
}

TEST_F(TransferOfARecording, RefusesToBeItsOwnCopy) {
  try {
    transfer("/drives/monday", "/drives", {}, {}, car_, car_);
    ADD_FAILURE() << "was refused by nobody";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/drives/monday: is the recording itself"));
  }
}

// Perhaps no disk is mounted at the target.
TEST_F(TransferOfARecording, RefusesAFolderThatIsNotThere) {
  try {
    transfer("/drives/monday", "/media/usb", {}, {}, car_, far_);
    ADD_FAILURE() << "was refused by nobody";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/media/usb: there is no such folder"));
  }
}

TEST_F(TransferOfARecording, ReadsTheCopyBack) {
  // A disk that alters its bytes once they are synced.
  far_.set_fault([&](DiskCall call, std::int64_t, const std::string& path) {
    if (call == DiskCall::kSync && path == "/archive/monday.part")
      far_.flip_bit("/archive/monday.part/seg-000002.lcm", 77'777);
    return SimulatedDisk::Outcome{};
  });
  EXPECT_THAT(refusal(), HasSubstr("seg-000002.lcm: reads back otherwise than it was written"));
  far_.set_fault({});
  expect_equal(far_, transfer_to(far_));
}

TEST_F(TransferOfARecording, RefusesWhatIsNoRecording) {
  car_.set_read_only(false);
  create_folders("/drives/empty", car_);
  EXPECT_THROW(transfer("/drives/empty", "/archive", {}, {}, car_, far_), std::runtime_error);
  create_folders("/drives/monday/inside", car_);
  EXPECT_THAT(refusal(), HasSubstr("/drives/monday/inside: a folder"));
}

// On real disks: sha256sum of coreutils agrees.
TEST(Transfer, LeavesDigestsThatSha256sumConfirms) {
  const test::TemporaryDirectory work;
  const auto from = work.path() / "wednesday", to = work.path() / "archive";
  const auto second = work.path() / "second";
  for (const auto& folder : {from, to, second}) std::filesystem::create_directories(folder);
  for (const auto& [name, bytes] : kRecording)
    std::ofstream(from / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  const TransferReport report = transfer(from / "", to, {}, {});
  EXPECT_EQ(report.to, to / "wednesday");
  const std::string check =
      "cd '" + report.to.string() + "' && sha256sum --quiet --strict -c " + kDigestsFile;
  EXPECT_EQ(std::system(check.c_str()), 0);
  // A copy is a recording like any other.
  const TransferReport again = transfer(report.to, second, {}, {});
  EXPECT_EQ(again.file.size(), kRecording.size());
}

// The disk that it is taken to may be of Windows or macOS.
TEST_F(TransferOfARecording, HasANameThatOtherSystemsTake) {
  create_folders("/archive/Monday", far_);
  EXPECT_THAT(refusal(),
              HasSubstr("/archive/monday: \"Monday\" lies beside it and differs by capitals only"));
  EXPECT_FALSE(path_exists("/archive/monday.part", far_));
}

// Opening a pipe would wait for a program that writes to it; a link leads to files of others.
TEST(Transfer, RefusesWhatIsNoFile) {
  const test::TemporaryDirectory work;
  const auto from = work.path() / "thursday", to = work.path() / "archive";
  for (const auto& folder : {from, to}) std::filesystem::create_directories(folder);
  std::ofstream(from / "seg-000001.lcm") << "samples";
  const auto refusal = [&]() -> std::string {
    try {
      transfer(from, to, {}, {});
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  ASSERT_EQ(::mkfifo((from / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(refusal(), HasSubstr((from / "pipe").string() + ": a pipe, which no recording has"));
  std::filesystem::remove(from / "pipe");
  std::filesystem::create_symlink("/etc/passwd", from / "notes.txt");
  EXPECT_THAT(refusal(), HasSubstr((from / "notes.txt").string() + ": a link, which no recording has"));
  EXPECT_TRUE(std::filesystem::is_empty(to)) << "its content is copied nowhere";
}

}  // namespace
}  // namespace roadbalance
