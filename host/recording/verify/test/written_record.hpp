#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <optional>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record_writer.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance::test {

inline constexpr std::int64_t kEpoch = 42;

/// A record of one epoch of one node, written block by block.
class WrittenRecord : public ::testing::Test {
 protected:
  WrittenRecord()
      : folder(std::filesystem::temp_directory_path() /
               ("rb-verify-" + std::to_string(::getpid()) + "-" +
                ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::remove_all(folder);
    writer.emplace(RecordWriter::Options{.folder = folder});
  }
  ~WrittenRecord() override { std::filesystem::remove_all(folder); }

  BlockHeader header(std::int64_t first_scan, std::int64_t scans) {
    return {.node = 1,
            .epoch = kEpoch,
            .sequence = ++sequence,
            .first_scan = first_scan,
            .scans = scans,
            .time_ns = 0};
  }
  template <typename Block>
  void put(const Block& block) {
    SealedBlock sealed;
    seal(block, sealed);
    if (sealed.header.sequence > 0) sum.add(sealed);
    writer->append(block_channel(1, sealed.kind), sealed.bytes(), 0);
  }
  void put_scans(std::int64_t first_scan) {
    ScanBlock block;
    block.header = header(first_scan, 20);
    block.period_ps = 1;
    put(block);
  }
  void put_gap(std::int64_t first_scan, std::int64_t scans, GapCause cause) {
    put(GapBlock{.header = header(first_scan, scans), .cause = cause});
  }
  void put_end(std::int64_t scans, std::int64_t missing = 0) {
    put(EndBlock{.header = header(scans + missing, 0),
                 .blocks = sequence,
                 .scans_sealed = scans,
                 .scans_missing = missing,
                 .blocks_crc32c = sum.crc32c()});
  }
  Verification result() {
    writer->close();
    return verify_record(folder);
  }

  const std::filesystem::path folder;
  std::optional<RecordWriter> writer;
  std::int64_t sequence = 0;
  BlockSum sum;
};

}  // namespace roadbalance::test
