#include "common/record/written_segment.hpp"

#include <system_error>

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

}  // namespace roadbalance
