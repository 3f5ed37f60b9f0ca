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

bool Feed::expect(std::int64_t viewer, WallTime now) {
  if (!viewers_.contains(viewer) && viewers_.size() >= kMostViewers) return false;
  viewers_[viewer].heard = now;
  return true;
}

void Feed::take(TopicMessage message, WallTime now) {
  const std::int64_t viewer = message.topic.viewer;
  if (viewer != 0 && !viewers_.contains(viewer)) return;
  Newests& newest = viewer == 0 ? newest_ : viewers_.at(viewer).newest;
  if (viewer == 0 && !newest.contains(message.topic)) make_room(message.topic.kind);
  if (!newest.contains(message.topic) && newest.size() >= (viewer == 0 ? kMostTopics : kMostTopicsOfAViewer))
    return;
  newest[message.topic] = {++revision_, now, std::move(message.bytes)};
}

// Topics with arbitrary keys must not crowd out those of the nodes and the recorder.
void Feed::make_room(std::size_t kind) {
  const std::size_t most = page_messages()[kind].most;
  if (most == 0) return;
  std::size_t count = 0;
  auto oldest = newest_.end();
  for (auto at = newest_.begin(); at != newest_.end(); ++at) {
    if (at->first.kind != kind) continue;
    ++count;
    if (oldest == newest_.end() || at->second.revision < oldest->second.revision) oldest = at;
  }
  if (count >= most) newest_.erase(oldest);
}

void Feed::forget_silent(WallTime now) {
  shared_ = {};  // ages grow while nothing comes
  std::erase_if(newest_, [&](const auto& entry) {
    const PageMessage& message = page_messages()[entry.first.kind];
    return message.is_state && now - entry.second.came > (message.is_answer ? kForgetAnswer : kForget);
  });
  std::erase_if(viewers_, [&](const auto& viewer) { return now - viewer.second.heard > kForgetViewer; });
  for (auto& [id, viewer] : viewers_)
    std::erase_if(viewer.newest, [&](const auto& entry) { return now - entry.second.came > kForgetViewer; });
}

Frame Feed::since(std::uint64_t revision, WallTime now, std::int64_t viewer) {
  if (revision == revision_) return {revision_, nullptr};
  if (const auto own = viewers_.find(viewer); viewer != 0 && own != viewers_.end())
    return frame(revision, now, &own->second.newest);
  if (shared_.bytes && shared_.revision == revision_ && shared_since_ == revision) return shared_;
  shared_since_ = revision;
  return shared_ = frame(revision, now, nullptr);
}

Frame Feed::frame(std::uint64_t revision, WallTime now, const Newests* own) const {
  std::vector<const Newest*> news;
  for (const Newests* newests : {&newest_, own})
    if (newests)
      for (const auto& [topic, newest] : *newests)
        if (newest.revision > revision) news.push_back(&newest);
  FrameBytes bytes;
  append_u32(bytes, kFrameMark);
  append_u32(bytes, news.size());
  for (const Newest* const newest : news) {
    append_u32(bytes, age_ms(newest->came, now));
    append_u32(bytes, newest->bytes.size());
    bytes.insert(bytes.end(), newest->bytes.begin(), newest->bytes.end());
  }
  return {revision_, std::make_shared<const FrameBytes>(std::move(bytes))};
}

}  // namespace roadbalance
