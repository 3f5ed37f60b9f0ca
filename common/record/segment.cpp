#include "common/record/segment.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include "common/record/folder.hpp"
#include "common/record/log_event.hpp"
#include "common/types/crc32c.hpp"

namespace roadbalance {
namespace {

// Room for the longest event and the sync word behind it, and for few system calls.
constexpr std::size_t kBufferBytes = std::size_t{256} << 10;
static_assert(kBufferBytes > 2 * kMaxLogEventBytes);

// The first byte at or behind `from` that may begin an event, or the end.  The library's search, which takes
// many bytes at a time: each event is looked through.
const std::uint8_t* find_sync(const std::uint8_t* from, const std::uint8_t* end) {
  if (from == end) return end;
  const void* found = std::memchr(from, kLogSync >> 24, static_cast<std::size_t>(end - from));
  return found ? static_cast<const std::uint8_t*>(found) : end;
}

// A length that was damaged may reach just to the end of a later event, which would be lost with it.
bool has_event_inside(std::span<const std::uint8_t> bytes) {
  const std::uint8_t* end = bytes.data() + bytes.size();
  for (const auto* at = find_sync(bytes.data(), end); at != end; at = find_sync(at + 1, end))
    if (parse_log_event({at, end}).status == ParsedEvent::Status::kEvent) return true;
  return false;
}

bool counts(ParsedEvent& parsed, std::span<const std::uint8_t> behind) {
  parsed.event.has_its_crc = ends_with_its_crc(parsed.event.data);
  return parsed.event.has_its_crc || (may_begin_event(behind) && !has_event_inside(parsed.event.data));
}

std::string file_name(int number, std::string_view ending) {
  char name[32];
  std::snprintf(name, sizeof name, "seg-%06d", number);
  return name + std::string(ending);
}

}  // namespace

SegmentReader::SegmentReader(std::filesystem::path path, Disk& disk)
    : file_(File::open_segment(path, disk)),
      buffer_(std::make_unique_for_overwrite<std::uint8_t[]>(kBufferBytes)) {
  file_.read_ahead();
}

std::span<const std::uint8_t> SegmentReader::unread() const {
  return {buffer_.get() + at_, filled_ - at_};
}

// Reads again from the place we look at: an unfinished event may have been cut off meanwhile.
// True if there are more bytes now than before.
bool SegmentReader::refill() {
  const std::size_t before = filled_ - at_;
  offset_ += at_;
  at_ = 0;
  const std::size_t room = offset_ < limit_ ? std::min<std::uint64_t>(limit_ - offset_, kBufferBytes) : 0;
  std::erase_if(unreadable_, [this](const auto& hole) { return hole.from >= offset_; });
  if (!unreadable_.empty()) unreadable_.back().to = std::min(unreadable_.back().to, offset_);
  filled_ = file_.read_around(offset_, {buffer_.get(), room}, unreadable_);
  return filled_ > before;
}

SegmentReader::Step SegmentReader::step(LogEvent& event, bool complete) {
  ParsedEvent parsed = parse_log_event(unread());
  const bool needs_more =
      parsed.status == ParsedEvent::Status::kIncomplete ||
      (parsed.status == ParsedEvent::Status::kEvent && unread().size() < parsed.bytes + 4);
  if (needs_more) {
    refill();  // moves the bytes that `parsed` points to
    parsed = parse_log_event(unread());
  }
  if (parsed.status == ParsedEvent::Status::kIncomplete)
    return complete && !unread().empty() ? Step::kSkip : Step::kMore;
  if (parsed.status == ParsedEvent::Status::kInvalid) return Step::kSkip;
  if (has_unreadable(offset_ + at_, offset_ + at_ + parsed.bytes)) return Step::kSkip;
  if (!counts(parsed, unread().subspan(parsed.bytes))) return Step::kSkip;
  at_ += parsed.bytes;
  event = parsed.event;
  return Step::kEvent;
}

// To the next byte that may begin an event.
void SegmentReader::skip() {
  const auto bytes = unread();
  const std::uint8_t* found = find_sync(bytes.data() + 1, bytes.data() + bytes.size());
  at_ += static_cast<std::size_t>(found - bytes.data());
}

bool SegmentReader::has_unreadable(std::uint64_t from, std::uint64_t to) const {
  return std::ranges::any_of(unreadable_, [&](const auto& hole) { return hole.from < to && hole.to > from; });
}

void SegmentReader::close_damage(std::vector<RecordReader::Damage>& damage, std::uint64_t end) {
  const auto account = [&](std::uint64_t to, std::string what) {
    to = std::min(to, end);
    if (to > accounted_)
      damage.push_back(
          {.segment = path(), .offset = accounted_, .bytes = to - accounted_, .what = std::move(what)});
    accounted_ = std::max(accounted_, to);
  };
  for (const auto& hole : unreadable_) {
    if (hole.to <= accounted_) continue;
    account(hole.from, kIsNoEvent);
    account(hole.to, "cannot be read: " + std::generic_category().message(EIO));
  }
  account(end, kIsNoEvent);
  std::erase_if(unreadable_, [this](const auto& hole) { return hole.to <= accounted_; });
}

std::optional<LogEvent> SegmentReader::next(bool complete, std::vector<RecordReader::Damage>& damage) {
  LogEvent event;
  for (;;) {
    if (unread().empty() && !refill()) break;
    const Step result = step(event, complete);
    if (result == Step::kMore) break;
    if (result == Step::kSkip) {
      skip();
      continue;
    }
    const std::uint64_t end = offset_ + at_;
    event_offset_ = end - (kLogHeaderBytes + event.channel.size() + event.data.size());
    close_damage(damage, event_offset_);
    end_of_events_ = accounted_ = end;
    return event;
  }
  if (complete) close_damage(damage, offset_ + filled_);
  return std::nullopt;
}

std::filesystem::path segment_path(const std::filesystem::path& folder, int number) {
  return folder / file_name(number, ".lcm");
}

std::optional<int> segment_of_file(std::string_view name, std::string_view ending) {
  constexpr std::string_view kBeginning = "seg-";
  int number = 0;
  if (!name.starts_with(kBeginning)) return std::nullopt;
  std::from_chars(name.data() + kBeginning.size(), name.data() + name.size(), number);
  return number > 0 && name == file_name(number, ending) ? std::optional(number) : std::nullopt;
}

std::vector<int> segment_numbers(const std::filesystem::path& folder, Disk& disk) {
  std::vector<int> numbers;
  for (const std::string& name : list_folder(folder, disk))
    if (const auto number = segment_of_file(name, ".lcm")) numbers.push_back(*number);
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace roadbalance
