#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "common/record/record_reader.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"

namespace roadbalance::test {
namespace {

const std::filesystem::path kFolder = "/drive";

class RecordReaderTest : public ::testing::Test {
 protected:
  RecordReaderTest() {
    Feeder feeder({.folder = kFolder, .segment_bytes = 8 << 10}, disk);
    feeder.append_through(60);
    feeder.close();
    numbers = segment_numbers(kFolder, disk);
  }

  // The retention mode takes `through` and all before away when a reader that has listed it comes to open it.
  void delete_when_opened(int through) {
    disk.set_fault([this, through, done = false](DiskCall call, std::int64_t,
                                                 const std::string& path) mutable {
      if (call == DiskCall::kOpen && path == segment_path(kFolder, through) && !std::exchange(done, true)) {
        for (const int number : numbers)
          if (number <= through) disk.unlink(segment_path(kFolder, number).c_str());
      }
      return SimulatedDisk::Outcome{};
    });
  }

  std::vector<int> segments_given(RecordReader& reader) {
    std::vector<int> given;
    while (reader.next())
      if (given.empty() || given.back() != reader.segment()) given.push_back(reader.segment());
    return given;
  }

  SimulatedDisk disk;
  std::vector<int> numbers;
};

TEST_F(RecordReaderTest, GoesOnBehindSegmentsThatAreDeletedWhenItComesToThem) {
  ASSERT_GT(numbers.size(), 5u);
  RecordReader reader(kFolder, disk);
  ASSERT_TRUE(reader.next());
  delete_when_opened(3);
  const auto given = segments_given(reader);
  EXPECT_EQ(std::count(given.begin(), given.end(), 3), 0);
  EXPECT_EQ(given.back(), numbers.back());
}

TEST_F(RecordReaderTest, BeginsBehindSegmentsThatAreDeletedMeanwhile) {
  delete_when_opened(1);
  RecordReader reader(kFolder, disk);
  EXPECT_EQ(segments_given(reader), std::vector<int>(numbers.begin() + 1, numbers.end()));
}

TEST_F(RecordReaderTest, SaysSoIfNoneIsLeft) {
  delete_when_opened(numbers.back());
  EXPECT_THROW(RecordReader(kFolder, disk, numbers.back()), std::system_error);
}

TEST_F(RecordReaderTest, ASegmentThatCannotBeOpenedIsNotPassedOver) {
  RecordReader reader(kFolder, disk);
  disk.set_fault([](DiskCall call, std::int64_t, const std::string& path) -> SimulatedDisk::Outcome {
    return {.error = call == DiskCall::kOpen && path.ends_with("seg-000002.lcm") ? EACCES : 0};
  });
  EXPECT_THROW(segments_given(reader), std::system_error);
}

}  // namespace
}  // namespace roadbalance::test
