#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "common/record/segment.hpp"
#include "host/recorder/test/store_drive.hpp"
#include "host/recording/verify/verify_missing.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using test::DiskCall;
using test::Drive;
using test::Outcome;

// For every call in turn, alone or with those that follow: whatever is reported durable is there after a
// power cut, and once the disk works again everything is there, without help of the nodes.
class EveryCall : public ::testing::TestWithParam<Outcome> {
 protected:
  // False if the drive has no such call.
  bool drive_with_fault_at(std::int64_t first, std::int64_t count, bool power_cut) {
    Drive drive(static_cast<std::uint64_t>(first));
    drive.options.segment_bytes = 28 << 10;  // a preamble is half of it
    drive.disk.set_fault([&](DiskCall, std::int64_t number, const std::string&) {
      return number >= first && number < first + count ? GetParam() : Outcome{};
    });
    try {
      drive.start();
    } catch (const std::system_error&) {
      return true;  // a start may fail: its supervisor tries again
    }
    drive.run(milliseconds(2000), 40);
    const bool reached = drive.disk.calls() >= first;
    if (power_cut) {
      drive.disk.cut_power();
      drive.store.reset();
      drive.disk.power_on();
    } else {
      drive.run(milliseconds(1000) * (count + 1));
      drive.note_durable(drive.store->close(drive.now));
      EXPECT_EQ(drive.durable, 40) << "fault at call " << first;
    }
    if (drive.durable == 0) return reached;
    drive.fail_nothing();
    const auto found = drive.recorded();
    EXPECT_TRUE(std::ranges::includes(found, test::all_through(drive.durable)))
        << drive.durable << " promised, fault at call " << first << ", " << count << " times";
    return reached;
  }
};

TEST_P(EveryCall, ThatFailsLeadsToNoPromiseThatIsNotKept) {
  for (const bool power_cut : {true, false})
    for (const std::int64_t count : {1, 2, 7}) {
      std::int64_t k = 1;
      while (drive_with_fault_at(k, count, power_cut) && !HasFailure()) ++k;
      EXPECT_GT(k, 50) << "the drive has too few calls to prove much";
    }
}

INSTANTIATE_TEST_SUITE_P(EachError, EveryCall,
                         ::testing::Values(Outcome{.error = EIO}, Outcome{.error = ENOSPC},
                                           Outcome{.error = EROFS}, Outcome{.error = EINTR},
                                           Outcome{.short_write = true}));

// All samples are on the disk, which is full then; on a full disk a segment is begun for notes alone, and its
// name is not taken either.
TEST(LastWords, ThatTheDiskDoesNotTakeLeaveNoEmptySegment) {
  Drive drive;
  drive.start();
  drive.run(milliseconds(2000), 40);
  ASSERT_EQ(drive.durable, 40);
  int folder_syncs = 0;
  drive.disk.set_fault([&](DiskCall call, std::int64_t, const std::string& path) {
    const bool of_first = call == DiskCall::kWrite && path.find("seg-000001") != std::string::npos;
    const bool of_name = call == DiskCall::kSync && path == test::kFolder;
    folder_syncs += of_name ? 1 : 0;
    return Outcome{.error = of_first ? ENOSPC : of_name ? EIO : 0};
  });
  (void)drive.store->close(drive.now);
  EXPECT_EQ(drive.store->failure(), std::nullopt);
  EXPECT_EQ(folder_syncs, 1) << "a second segment was begun";
  drive.fail_nothing();
  EXPECT_EQ(segment_numbers(test::kFolder, drive.disk), std::vector{1});
  EXPECT_TRUE(find_missing_segments(test::kFolder, {}, {}, drive.disk).lines.empty());
  EXPECT_EQ(drive.recorded(), test::all_through(40));
}

}  // namespace
}  // namespace roadbalance
