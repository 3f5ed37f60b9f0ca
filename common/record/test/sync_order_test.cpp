#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <functional>

#include "common/record/record_writer.hpp"
#include "common/record/segment.hpp"
#include "common/test/temporary_directory.hpp"

namespace {

// Called with the path of every file and folder about to be synced.
std::function<void(const std::filesystem::path&)> watch_syncs;

int watched_sync(long call, int descriptor) {
  if (watch_syncs) watch_syncs(std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor)));
  return static_cast<int>(::syscall(call, descriptor));
}

}  // namespace

// In the place of the C library's.
extern "C" int fdatasync(int descriptor) {
  return watched_sync(SYS_fdatasync, descriptor);
}
extern "C" int fsync(int descriptor) {
  return watched_sync(SYS_fsync, descriptor);
}

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

class SyncOrder : public ::testing::Test {
 protected:
  static void append(RecordWriter& writer, int count) {
    for (int k = 0; k < count; ++k) writer.append("CHANNEL", std::vector<std::uint8_t>(50), 1000 * k);
  }

  const test::TemporaryDirectory directory;
  const fs::path folder = fs::canonical(directory.path()) / "record";
};

// At the syncs, which are watched here: a power cut keeps what was synced before it, and any part of the
// rest.
TEST_F(SyncOrder, ASegmentIsOnTheDiskBeforeTheNextOneHasAName) {
  fs::create_directories(folder);
  std::uintmax_t synced = 0;
  watch_syncs = [&](const fs::path& path) {
    if (path == segment_path(folder, 1) && !fs::exists(segment_path(folder, 2))) synced = fs::file_size(path);
  };
  RecordWriter writer({.folder = folder, .segment_bytes = 1000});
  append(writer, 40);
  watch_syncs = nullptr;
  ASSERT_TRUE(fs::exists(segment_path(folder, 2)));
  EXPECT_EQ(synced, fs::file_size(segment_path(folder, 1)));
}

TEST_F(SyncOrder, ATornTailHasItsNameOnTheDiskBeforeTheSegmentIsCut) {
  {
    RecordWriter writer({.folder = folder});
    append(writer, 10);
    writer.close();
  }
  const auto segment = segment_path(folder, 1);
  const auto torn = fs::file_size(segment) - 5;
  fs::resize_file(segment, torn);
  bool named = false;
  watch_syncs = [&](const fs::path& path) {
    if (path == folder && fs::exists(folder / "seg-000001.tail")) named |= fs::file_size(segment) == torn;
  };
  RecordWriter writer({.folder = folder});
  watch_syncs = nullptr;
  EXPECT_TRUE(writer.cut_tail());
  EXPECT_TRUE(named);
}

}  // namespace
}  // namespace roadbalance
