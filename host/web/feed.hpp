#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "common/types/clocks.hpp"
#include "host/web/topics.hpp"

namespace roadbalance {

/// A frame for one page: binary, all numbers big endian.
///
///     u32 "RBF1"; u32 number of messages; for each: u32 age in ms, u32 size, the message as it was on the
///     bus
using FrameBytes = std::vector<std::uint8_t>;
inline constexpr std::uint32_t kFrameMark = 0x52424631;

struct Frame {
  std::uint64_t revision = 0;                 ///< of the feed, after this frame
  std::shared_ptr<const FrameBytes> bytes{};  ///< nullptr: nothing is new
};

/// The newest message of each topic, for pages that come late or are slow: a page that missed ten gets the
/// last one. Answers to a page's View go to that page alone.  A pure state machine of bounded memory.
class Feed {
 public:
  static constexpr std::size_t kMostTopics = 512;
  /// A state that is not repeated for so long is forgotten.  Its age is sent with it, so that a page that is
  /// opened later still shows a node or recorder that has fallen silent.
  static constexpr std::chrono::hours kForget{1};
  static constexpr std::chrono::minutes kForgetAnswer{1};

  /// Limits of pages with topics of their own, and of such topics for each.
  static constexpr std::size_t kMostViewers = 32, kMostTopicsOfAViewer = 512;
  /// A page that asks no more is forgotten, with its topics.
  static constexpr std::chrono::seconds kForgetViewer{10};

  /// A page asks for topics of its own.  False: too many pages do.
  bool expect(std::int64_t viewer, WallTime now);
  /// Takes a message; one for a page that did not ask, or is unknown here, is dropped.
  void take(TopicMessage message, WallTime now);
  void forget_silent(WallTime now);

  /// All messages after a revision; 0: all.  Pages of the same revision without topics of their own share one
  /// frame.
  Frame since(std::uint64_t revision, WallTime now, std::int64_t viewer = 0);

  std::size_t topics() const { return newest_.size(); }

 private:
  struct Newest {
    std::uint64_t revision;
    WallTime came;
    std::vector<std::uint8_t> bytes;
  };
  using Newests = std::map<Topic, Newest>;
  struct Viewer {
    WallTime heard;
    Newests newest{};
  };
  void make_room(std::size_t kind);
  Frame frame(std::uint64_t revision, WallTime now, const Newests* own) const;

  Newests newest_;
  std::map<std::int64_t, Viewer> viewers_;
  std::uint64_t revision_ = 0;
  std::uint64_t shared_since_ = 0;
  Frame shared_;
};

}  // namespace roadbalance
