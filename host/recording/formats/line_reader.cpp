#include "host/recording/formats/line_reader.hpp"

#include <algorithm>
#include <span>

#include "common/config/section.hpp"

namespace roadbalance {

std::shared_ptr<const File> open_again_and_again(const std::filesystem::path& path) {
  // Opening a pipe would wait for a program that writes to it.
  if (std::filesystem::exists(path) && !std::filesystem::is_regular_file(path))
    throw ConfigError(path.string() + ": is no file; allowed: one that can be read twice");
  return std::make_shared<const File>(File::open_to_read(path));
}

bool LineReader::next() {
  std::size_t searched = begin_;
  auto end = held_.end();
  while ((end = std::find(held_.begin() + static_cast<std::ptrdiff_t>(searched), held_.end(), '\n')) ==
         held_.end()) {
    if (held_.size() - begin_ > kLongestLine) {
      ++number_;
      fail("is longer than 1 MiB; allowed: a text of lines");
    }
    searched = held_.size() - begin_;
    if (hold_more()) continue;
    if (begin_ == held_.size()) return false;
    end = held_.end();
    break;
  }
  const auto size = static_cast<std::size_t>(end - held_.begin()) - begin_;
  line_ = std::string_view(held_.data() + begin_, size);
  begin_ = std::min(begin_ + size + 1, held_.size());
  if (line_.ends_with('\r')) line_.remove_suffix(1);
  ++number_;
  return true;
}

/// Drops the lines that are done and reads on.  False at the file's end.
bool LineReader::hold_more() {
  constexpr std::size_t kPart = 16 << 10;
  held_.erase(held_.begin(), held_.begin() + static_cast<std::ptrdiff_t>(begin_));
  held_from_ += begin_;
  begin_ = 0;
  const std::size_t before = held_.size();
  held_.resize(before + kPart);
  std::span<char> room = std::span(held_).subspan(before);
  const std::size_t read =
      file_->read_at(held_from_ + before, {reinterpret_cast<std::uint8_t*>(room.data()), room.size()});
  held_.resize(before + read);
  return read > 0;
}

double LineReader::part() const {
  const std::uint64_t size = file_->size();
  return size > 0 ? static_cast<double>(place().byte) / static_cast<double>(size) : 1.0;
}

void LineReader::fail(const std::string& reason) const {
  throw ConfigError(file_->path().string() + ":" + std::to_string(std::max<std::int64_t>(number_, 1)) + ": " +
                    reason);
}

}  // namespace roadbalance
