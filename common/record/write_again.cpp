#include "common/record/write_again.hpp"

#include <vector>

namespace roadbalance {

void write_again(File& file, std::uint64_t from, Disk& disk) {
  constexpr std::size_t kCopyBytes = std::size_t{256} << 10;
  const File source = File::open_to_read(file.path(), disk);
  std::vector<std::uint8_t> buffer(kCopyBytes);
  for (;;) {
    const std::size_t got = source.read_at(from, buffer);
    if (got == 0) break;
    file.write_all_at(from, {buffer.data(), got});
    from += got;
  }
  file.sync();
}

}  // namespace roadbalance
