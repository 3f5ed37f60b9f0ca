#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <span>
#include <vector>

namespace roadbalance::test {

/// The content of one file on a SimulatedDisk, as the page cache has it and as the platter has it.
///
/// Only what differs is kept twice, so that appending costs one copy.  A power cut leaves of each sector that
/// was not synced the old or the new content, of the length the old or the new one or one between.
class SimulatedFile {
 public:
  static constexpr std::uint64_t kSectorBytes = 512;

  /// @param used_bytes  the disk's count of space taken, kept up to date by each of its files
  explicit SimulatedFile(std::shared_ptr<std::int64_t> used_bytes);
  SimulatedFile(const SimulatedFile&) = delete;
  SimulatedFile& operator=(const SimulatedFile&) = delete;
  ~SimulatedFile();

  std::uint64_t size() const { return size_; }
  std::size_t read(std::uint64_t offset, std::span<std::uint8_t> into) const;
  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  void resize(std::uint64_t size);
  /// Space that is taken though nothing is written there; the length stays.
  void reserve(std::uint64_t size);
  /// Space that would be taken in all if the file had this length.
  std::int64_t space_for(std::uint64_t size) const;

  void sync();
  /// As Linux does: the pages count as clean from now on, whether they reached the platter or not, and the
  /// next sync succeeds.
  void fail_sync(std::mt19937_64& random);
  /// The page cache is gone, the platter is what counts.
  /// @return sectors in it that are not as they were written last
  std::int64_t lose_power(std::mt19937_64& random);
  /// Alters a byte unnoticed, in cache and platter.
  void damage(std::uint64_t offset, std::uint8_t flipped_bits);

 private:
  using Sector = std::array<std::uint8_t, kSectorBytes>;
  struct Old {
    Sector bytes;
    bool lost = false;  // counts as clean, but the platter still has these bytes
  };
  static constexpr std::uint64_t kChunkBytes = std::uint64_t{64} << 10;

  void put(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  void put_zeros(std::uint64_t from, std::uint64_t to);
  void set_size(std::uint64_t size);
  void account();
  Sector platter_sector(std::uint64_t sector) const;
  void keep_old(std::uint64_t from, std::uint64_t to);
  void mark_dirty(std::uint64_t from_sector, std::uint64_t to_sector);
  std::uint64_t size_after_power_cut(std::mt19937_64& random) const;
  bool tear(std::uint64_t sector, std::mt19937_64& random);

  std::shared_ptr<std::int64_t> used_bytes_;
  std::int64_t accounted_bytes_ = 0;
  std::vector<std::unique_ptr<std::uint8_t[]>> chunks_;
  std::uint64_t size_ = 0;
  std::uint64_t platter_size_ = 0;
  std::uint64_t reserved_ = 0;
  std::map<std::uint64_t, std::uint64_t> dirty_;  // first sector -> one past the last; apart from one another
  std::map<std::uint64_t, Old> old_;  // sectors whose old content cannot be distinguished from the new
};

}  // namespace roadbalance::test
