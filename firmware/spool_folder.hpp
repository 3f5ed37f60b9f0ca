#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/link/spool.hpp"
#include "common/record/disk.hpp"
#include "common/record/file.hpp"

namespace roadbalance {

/// Blocks on the node's disk, as segments of a record: any LCM reader opens them, and a recording folder is
/// completed from them.  Every segment begins with the description of the epoch.
///
/// A block counts as kept once its data and its file's name are synced.  A file that a call failed on is not
/// written again; the blocks of that call stay where they were, and the next call waits a second unless the
/// program ends.  A segment whose blocks are all given back is removed; one of which a block was given up
/// stays, and takes its space, for `rb recover --spool`: it may be read elsewhere, or later.
///
/// Memory: 4 bytes a block on the disk, and one batch of keep().
class SpoolFolder final : public Spool {
 public:
  struct Options {
    std::filesystem::path folder;  ///< its own; made, and locked while the node lives
    std::uint64_t bytes = 0;       ///< of all segments
    std::int32_t node = 0;
    std::int64_t epoch = 0;
  };
  /// @throws std::invalid_argument if `bytes` is less than kLeastBytes, std::system_error naming the folder
  explicit SpoolFolder(Options options, Disk& disk = kernel_disk());

  std::int64_t base() const override { return base_; }
  std::int64_t next() const override { return next_; }
  std::int64_t capacity() const override;
  std::int64_t failures() const override { return failures_; }
  void describe(const SealedBlock& meta) override;
  void keep(const Ring& ring, std::int64_t first, std::int64_t last, WallTime now) override;
  void never_wait() override { waits_ = false; }
  bool read(std::int64_t sequence, SealedBlock& out) override;
  bool answers() override;
  void free_through(std::int64_t sequence) override;
  void give_up_through(std::int64_t sequence) override;

  static constexpr std::uint64_t kLeastBytes = std::uint64_t{1} << 20;

 private:
  struct Segment {
    int number = 0;
    std::int64_t first = 0;              // sequence
    std::vector<std::uint32_t> offsets;  // of its blocks
    std::uint64_t bytes = 0;             // behind the last of them
    std::uint64_t uncut = 0;             // behind those, of a call that failed
    bool given_up = false;               // a block of it at least

    std::int64_t next() const { return first + static_cast<std::int64_t>(offsets.size()); }
  };
  std::filesystem::path path(int segment) const;
  std::uint64_t bytes_used() const;
  void put(const SealedBlock& block);
  void write_batch(const Ring& ring, std::int64_t first, std::int64_t last);
  void begin_segment(std::int64_t first);
  void commit();
  void give_up_file();
  void remove_freed();

  const Options options_;
  Disk& disk_;
  const std::uint64_t segment_bytes_;
  std::vector<std::uint8_t> preamble_;  // encoded events
  std::deque<Segment> segments_;        // in order; the last one is written to while writer_ is open
  std::deque<Segment> freed_;           // not removed yet
  std::uint64_t left_bytes_ = 0;        // of those that stay
  File folder_, writer_, reader_;
  int reading_ = 0;  // segment that reader_ is open on
  int last_number_ = 0;
  std::int64_t events_ = 0;
  std::vector<std::uint8_t> batch_;  // events not written yet
  std::vector<std::uint32_t> batch_offsets_;
  std::vector<std::uint8_t> event_;  // read back
  std::int64_t base_ = 1, next_ = 1;
  WallTime retry_at_{};
  bool waits_ = true;
  std::int64_t failures_ = 0;
};

/// "node-3-00c0ffee00c0ffee" in `directory`, for the epoch of a node.
std::filesystem::path spool_path(const std::filesystem::path& directory, std::int32_t node,
                                 std::int64_t epoch);

/// The folders in `directory` that earlier nodes left when they were killed; it is made if it does not exist.
/// Nodes that live are left out.
/// @param warn  gets the folders that bear such a name and cannot be looked into
/// @throws std::system_error naming the directory if it cannot be made or read
std::vector<std::filesystem::path> spools_left(const std::filesystem::path& directory,
                                               const std::function<void(const std::string&)>& warn,
                                               Disk& disk = kernel_disk());

}  // namespace roadbalance
