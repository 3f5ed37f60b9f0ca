#include "common/record/written_segment.hpp"

#include <system_error>

#include "common/record/folder.hpp"

namespace roadbalance {

void WrittenSegment::finish(const std::filesystem::path& folder, Disk& disk) {
  file.truncate(index.bytes);
  file.sync();
  file.close();
  try {
    write_index(folder, index, disk);
  } catch (const std::system_error&) {
    // The record is good without it; only the next start takes longer.
  }
}

bool cut_back(File segment, std::uint64_t durable_bytes, const std::filesystem::path& path, Disk& disk) {
  try {
    if (durable_bytes > 0)
      segment.truncate(durable_bytes);
    else if (segment.is_at(path))
      (void)remove_file(path, disk);
    return true;
  } catch (const std::system_error&) {
    return false;
  }
}

}  // namespace roadbalance
