#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <vector>

#include "common/record/record_reader.hpp"

namespace roadbalance {

/// Every readable event of some folders, in an order that is always the same.
class RecoverySources {
 public:
  /// @throws std::system_error naming the folder
  RecoverySources(const std::vector<std::filesystem::path>& folders, Disk& disk);

  struct Place {
    std::size_t file = 0;
    std::uint64_t offset = 0;
  };
  /// @param counts  false: the event lies behind the end of an abandoned segment, or in a tail that was cut
  /// off
  /// @param damage  gets the bytes that are no event; those there, or in a segment that is_torn(), are `torn`
  using Take = std::function<void(const LogEvent& event, const Place& place, bool counts)>;
  void for_each(const Take& take, std::vector<RecordReader::Damage>& damage) const;

  const std::filesystem::path& file(const Place& place) const { return files_[place.file].path; }

  /// The bytes that a kill or a power cut leaves at the end of a record: never acknowledged as durable, so
  /// that their node has sent them again.
  bool is_torn(const Place& place) const { return place.offset >= files_[place.file].torn_from; }

  /// The event at a place that for_each() gave, which must hold a block.  @throws std::runtime_error if it
  /// changed
  SealedBlock block_at(const Place& place, std::int64_t& timestamp_us) const;

 private:
  struct Source {
    std::filesystem::path path;
    std::uint64_t end = 0;  // events from here on do not count
    std::uint64_t torn_from = std::numeric_limits<std::uint64_t>::max();
  };
  std::vector<Source> files_;
  Disk& disk_;
};

}  // namespace roadbalance
