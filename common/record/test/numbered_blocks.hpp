#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "common/record/record_reader.hpp"
#include "common/record/record_writer.hpp"

namespace roadbalance::test {

/// The `sequence`-th block of the one node epoch that these tests record: scans and, every third one,
/// something short.  Always the same.
const SealedBlock& numbered_block(std::int64_t sequence);

/// Numbers of the blocks of a record, in the order of the record.
struct FoundBlocks {
  std::vector<std::int64_t> sequences;
  std::int64_t false_blocks = 0;  ///< good by their CRC, but not as numbered_block() has them
  /// Events on a channel of ours that are not as they were written: where each begins in its segment.
  std::vector<std::uint64_t> altered;
  std::map<int, std::uint64_t> event_bytes;  ///< of all events, by segment
  struct Stretch {
    std::uint64_t from, to;
  };
  std::vector<Stretch> altered_headers;  ///< as HeaderCheck finds them
  std::vector<RecordReader::Damage> damage;
};
/// For a record that does not grow any more.
FoundBlocks find_blocks(const std::filesystem::path& folder, Disk& disk);

/// 1, 2, ... last.
std::vector<std::int64_t> all_through(std::int64_t last);

/// Feeds numbered blocks to a writer, as a recorder does: what a failing disk loses is given again.
class Feeder {
 public:
  /// Goes on behind what the folder holds.  @throws what RecordWriter throws
  Feeder(RecordWriter::Options options, Disk& disk);

  /// Until `sequence` is appended, or the disk has failed `kMostFailures` times: then false.
  bool append_through(std::int64_t sequence);
  bool sync();
  bool close();

  std::int64_t appended() const { return base_ + writer_.appended(); }
  std::int64_t durable() const { return base_ + writer_.durable(); }
  std::int64_t found() const { return base_; }  ///< in the folder at the start
  RecordWriter& writer() { return writer_; }

  static constexpr int kMostFailures = 3;

 private:
  template <typename Call>
  bool attempt(Call&& call);

  RecordWriter writer_;
  std::int64_t base_;
  int failures_ = 0;
};

}  // namespace roadbalance::test
