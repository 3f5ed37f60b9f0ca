#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <random>
#include <string>

#include "common/test/temporary_directory.hpp"
#include "hil_tests/program.hpp"
#include "hil_tests/recording_digests.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using test::Program;

/// That a process has read; it goes once through the original and once through its copy.
std::int64_t bytes_read(pid_t pid) {
  std::ifstream counters("/proc/" + std::to_string(pid) + "/io");
  std::string name;
  std::int64_t bytes = 0;
  return counters >> name >> bytes && name == "rchar:" ? bytes : 0;
}

/// @return false: it had ended before
bool kill_at(Program& program, std::int64_t bytes) {
  std::optional<int> code;
  while (bytes_read(program.pid()) < bytes)
    if (code = program.exit_code(0); code) return false;
  program.kill();
  return true;
}

TEST(TransferKilled, GoesOnAndTheCopyIsEqualWhereverItWasKilled) {
  const test::TemporaryDirectory work;
  const fs::path drive = work.path() / "drive", disk = work.path() / "disk", copy = disk / "drive";
  ASSERT_EQ(test::run("rb",
                      {"demo", "--headless", "--rate", "max", "--drive-seconds", "80", "--seed", "1",
                       "--record", drive.string()},
                      120),
            0);
  const auto before = test::digests_of(drive);
  std::int64_t size = 0;
  for (const auto& file : fs::directory_iterator(drive)) size += static_cast<std::int64_t>(file.file_size());
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::int64_t> anywhere(0, 2 * size);
  const int wanted = test::full_run() ? 100 : 10;
  int killed = 0, kept = 0;
  for (int tries = 0; killed < wanted; ++tries) {
    ASSERT_LT(tries, 20 * wanted) << "it ends before it can be killed";
    fs::remove_all(disk);
    fs::create_directories(disk);
    const std::vector<std::string> words{"transfer", drive.string(), "--to", disk.string()};
    Program first("rb", words);
    const std::int64_t place = anywhere(random);
    if (!kill_at(first, place)) continue;
    // Killed once more while it goes on, every second time.
    if (killed % 2 == 1) {
      Program second("rb", words);
      kill_at(second, anywhere(random));
    }
    ++killed;
    const bool is_half = fs::exists(copy.string() + ".part");
    kept += is_half ? 1 : 0;
    EXPECT_FALSE(is_half && fs::exists(copy)) << place;
    ASSERT_EQ(test::run("rb", words, 120), 0) << "killed after " << place << " bytes";
    EXPECT_FALSE(fs::exists(copy.string() + ".part"));
    EXPECT_EQ(test::digests_of(copy, "sha256.txt"), before) << "killed after " << place << " bytes";
    EXPECT_EQ(test::run("sh", {"-c", "cd '" + copy.string() + "' && sha256sum --quiet -c sha256.txt"}, 120),
              0);
    ASSERT_EQ(test::digests_of(drive), before) << "the source is as it was";
  }
  EXPECT_GT(kept, wanted / 2) << "most were killed while they copied";
  std::printf("%d transfers of %.1f MB killed, %d with half a copy\n", killed,
              1e-6 * static_cast<double>(size), kept);
}

}  // namespace
}  // namespace roadbalance
