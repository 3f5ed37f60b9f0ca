#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace roadbalance {

/// A subject of which only the newest message counts: the levels of node 2, the balance of wheel 0.
struct Topic {
  std::size_t kind = 0;     ///< which of page_messages()
  std::int64_t key = 0;     ///< node, wheel or incarnation; 0 if the kind has one topic
  std::int64_t viewer = 0;  ///< the page that asked for it (View); 0: for all pages
  auto operator<=>(const Topic&) const = default;
};

/// A kind of message that the page shows.
struct PageMessage {
  const char* channels;  ///< LCM channels, as Bus::subscribe takes them
  /// Topic::key of a message as it came; nothing if the message is invalid.
  std::optional<std::int64_t> (*key)(std::span<const std::uint8_t> bytes);
  /// True for a state, which is repeated, and forgotten in silence.  A result stays.
  bool is_state;
  /// Topic::viewer of a valid message; nullptr: for all pages.
  std::int64_t (*viewer)(std::span<const std::uint8_t> bytes) = nullptr;
  /// Most topics of a kind whose keys are arbitrary; the oldest makes room.  0: no limit.
  std::size_t most = 0;
  /// An answer is useful to the page that asked, for a short while.
  bool is_answer = false;
};

/// All messages that the page gets.  It decodes them itself: see page/README.md.
std::span<const PageMessage> page_messages();

/// A valid message, as it came.
struct TopicMessage {
  Topic topic;
  std::vector<std::uint8_t> bytes;
};

}  // namespace roadbalance
