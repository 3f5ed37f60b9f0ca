#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace roadbalance {

/// A thing of which only the newest message counts: the levels of node 2, the balance of wheel 0.
struct Topic {
  std::size_t kind = 0;     ///< which of page_messages()
  std::int64_t key = 0;     ///< node, wheel or incarnation; 0 where there is one only
  std::int64_t viewer = 0;  ///< the page that asked for it (View); 0: it is for all
  auto operator<=>(const Topic&) const = default;
};

/// A kind of message that the page shows.
struct PageMessage {
  const char* channels;  ///< LCM channels, as Bus::subscribe takes them
  /// Topic::key of a message as it came; nothing if it is not a good one.
  std::optional<std::int64_t> (*key)(std::span<const std::uint8_t> bytes);
  /// True of a state, which is said again and again: in silence it is forgotten.  A result stays.
  bool is_state;
  /// Topic::viewer of a good message; nullptr: it is for all.
  std::int64_t (*viewer)(std::span<const std::uint8_t> bytes) = nullptr;
  /// So many topics of a kind whose keys anybody on the bus can make up; the oldest makes room.  0: any
  /// number.
  std::size_t most = 0;
  /// It is of use to who asked, for a short while.
  bool is_answer = false;
};

/// All that the page is told.  It decodes them itself: see page/README.md.
std::span<const PageMessage> page_messages();

/// A good message, as it came.
struct TopicMessage {
  Topic topic;
  std::vector<std::uint8_t> bytes;
};

}  // namespace roadbalance
