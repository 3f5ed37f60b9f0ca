#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/bus/notes.hpp"
#include "common/clock/clock_table.hpp"

namespace roadbalance {

using NodeEpoch = std::pair<std::int32_t, std::int64_t>;
/// The events a segment begins with, so that it can be read without those before: channels and messages.
using RecordEvents = std::vector<std::pair<std::string, std::vector<std::uint8_t>>>;

/// The clocks as a record gives them, up to the event taken last: how each node's stands to the host's, and
/// the host's to UTC.
///
/// Each segment begins with events(), so that its samples can be placed on one time line without the segments
/// before it.
class RecordedClocks {
 public:
  /// Any event of the record; those of other channels are passed over.  A fit that it holds is given back if
  /// it is none that was repeated.
  std::optional<ClockFit> take(std::string_view channel, std::span<const std::uint8_t> data);

  /// The host's instant of a node's instant, by the fits that hold; nothing while none does.
  std::optional<std::int64_t> host_ns(const NodeEpoch& key, std::int64_t node_ns) const;
  /// UTC in microseconds of an instant of the host, by the pair of clocks noted last.
  std::optional<std::int64_t> utc_us(std::int64_t host_ns) const;

  /// The same as messages: the pair of clocks (NoteKind::kClock), then for each epoch that `wanted` selects
  /// the one to four fits of its row.  A reader that takes them has of these clocks what this one has, now
  /// and after whatever both take next.
  RecordEvents events(const std::function<bool(const NodeEpoch&)>& wanted) const;

 private:
  ClockTable fits_;
  std::optional<Note> pair_;
};

}  // namespace roadbalance
