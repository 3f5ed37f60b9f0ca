#include "host/web/feed.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

namespace roadbalance {
namespace {

void append_u32(FrameBytes& bytes, std::uint64_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

std::uint64_t age_ms(WallTime came, WallTime now) {
  const auto age = std::chrono::duration_cast<std::chrono::milliseconds>(now - came).count();
  return static_cast<std::uint64_t>(
      std::clamp<std::int64_t>(age, 0, std::numeric_limits<std::uint32_t>::max()));
}

}  // namespace

void Feed::take(TopicMessage message, WallTime now) {
  if (!newest_.contains(message.topic) && newest_.size() >= kMostTopics) return;
  newest_[message.topic] = {++revision_, now, std::move(message.bytes)};
}

void Feed::forget_silent(WallTime now) {
  shared_ = {};  // ages go on while nothing comes
  std::erase_if(newest_, [&](const auto& entry) {
    return page_messages()[entry.first.kind].is_state && now - entry.second.came > kForget;
  });
}

Frame Feed::since(std::uint64_t revision, WallTime now) {
  if (revision == revision_) return {revision_, nullptr};
  if (shared_.bytes && shared_.revision == revision_ && shared_since_ == revision) return shared_;
  FrameBytes bytes;
  append_u32(bytes, kFrameMark);
  append_u32(bytes,
             static_cast<std::uint64_t>(std::count_if(newest_.begin(), newest_.end(), [&](const auto& entry) {
               return entry.second.revision > revision;
             })));
  for (const auto& [topic, newest] : newest_) {
    if (newest.revision <= revision) continue;
    append_u32(bytes, age_ms(newest.came, now));
    append_u32(bytes, newest.bytes.size());
    bytes.insert(bytes.end(), newest.bytes.begin(), newest.bytes.end());
  }
  shared_since_ = revision;
  shared_ = {revision_, std::make_shared<const FrameBytes>(std::move(bytes))};
  return shared_;
}

}  // namespace roadbalance
