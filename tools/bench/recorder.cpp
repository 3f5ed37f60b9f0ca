#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <span>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/record/disk.hpp"
#include "host/recorder/recording_store.hpp"
#include "tools/bench/bare.hpp"
#include "tools/bench/bench_blocks.hpp"
#include "tools/bench/contest.hpp"

// The recorder's disk side beside what the disk does by itself: blocks appended and committed as fast as they
// are taken, and the same bytes in writes as large as a commit, each on the disk before the next (what `dd
// bs=4M oflag=dsync` does).  Time of the wall: a disk is waited for.  A line of JSON for tools/bench/run.

namespace roadbalance::bench {
namespace {

namespace fs = std::filesystem;
constexpr int kRounds = 5;
constexpr std::int64_t kBlocks = 60'000;  // an hour of driving of a node is 360 000

std::vector<SealedBlock> sealed_blocks() {
  std::vector<SealedBlock> blocks(kBlocks);
  ScanBlock block = scans();
  for (std::int64_t k = 0; k < kBlocks; ++k) {
    block.header = {.node = 1,
                    .epoch = 9,
                    .sequence = k + 1,
                    .first_scan = k * kScansPerBlock,
                    .scans = kScansPerBlock,
                    .time_ns = k * 10'000'000};
    seal(block, blocks[static_cast<std::size_t>(k)]);
  }
  return blocks;
}

/// @return bytes on the disk
std::uintmax_t record(const std::vector<SealedBlock>& blocks, const fs::path& folder) {
  RecordingStore store(kernel_disk(), {.folder = folder});
  store.begin();
  std::int64_t durable = 0;
  const auto take = [&](const std::vector<DurableMark>& marks) {
    for (const DurableMark& mark : marks) durable = mark.sequence;
  };
  for (const SealedBlock& block : blocks) {
    const WallTime now = WallClock::now();
    store.append(Delivery(block), now);
    if (store.commit_is_due(now))
      take(store.commit(now));
    else
      store.maintain();
  }
  take(store.close(WallClock::now()));
  if (durable != kBlocks) throw std::runtime_error(store.failure().value_or("not all is on the disk"));
  std::uintmax_t bytes = 0;
  for (const auto& file : fs::directory_iterator(folder))
    if (file.path().extension() == ".lcm") bytes += file.file_size();
  return bytes;
}

double seconds_of(auto&& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void run(const fs::path& scratch) {
  const std::vector<SealedBlock> blocks = sealed_blocks();
  std::vector<double> ours_s, disk_s, ratios;
  std::uintmax_t bytes = 0;
  for (int round = 0; round < std::min(kRounds, rounds_of_contest()); ++round) {
    const fs::path folder = scratch / "recorded", file = scratch / "bare";
    ours_s.push_back(seconds_of([&] { bytes = record(blocks, folder); }));
    disk_s.push_back(seconds_of([&] { write_bare(bytes, StoreOptions{}.commit_bytes, file); }));
    ratios.push_back(disk_s.back() / ours_s.back());
    fs::remove_all(folder);
    fs::remove(file);
  }
  const double megabytes = 1e-6 * static_cast<double>(bytes);
  tell("recorder, on the disk", "MB/s", megabytes / median(ours_s), "as dd bs=4M oflag=dsync",
       megabytes / median(disk_s), median(ratios));
}

}  // namespace
}  // namespace roadbalance::bench

int main(int argc, char** argv) {
  if (argc != 2 || !std::filesystem::is_directory(argv[1])) {
    std::fputs(
        "usage: bench-recorder FOLDER: on the disk that is measured; what it writes there it removes\n",
        stderr);
    return 2;
  }
  try {
    roadbalance::bench::run(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench-recorder: %s\n", error.what());
    return 4;
  }
}
