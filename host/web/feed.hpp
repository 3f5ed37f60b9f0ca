#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "common/clock/clocks.hpp"
#include "host/web/topics.hpp"

namespace roadbalance {

/// What one page is sent at once: binary, all numbers big endian.
///
///     u32 "RBF1"; u32 number of messages; of each: u32 age in ms, u32 size, the message as it was on the bus
using FrameBytes = std::vector<std::uint8_t>;
inline constexpr std::uint32_t kFrameMark = 0x52424631;

struct Frame {
  std::uint64_t revision = 0;                 ///< of the feed, that it leads to
  std::shared_ptr<const FrameBytes> bytes{};  ///< none: nothing is new
};

/// The newest message of each topic, for pages that come late and pages that are slow: a page that missed ten
/// gets the last one.  What a page asked for goes to it alone.  A pure state machine of bounded memory.
class Feed {
 public:
  static constexpr std::size_t kMostTopics = 512;
  /// A state that is not said again for so long is forgotten.  Its age is sent with it: a page that is opened
  /// later still learns of a node or recorder that has fallen silent.
  static constexpr std::chrono::hours kForget{1};
  static constexpr std::chrono::minutes kForgetAnswer{1};

  /// So many pages may ask for what is for them alone, so many topics each.
  static constexpr std::size_t kMostViewers = 32, kMostTopicsOfAViewer = 512;
  /// A page that asks no more is forgotten, and what it was told.
  static constexpr std::chrono::seconds kForgetViewer{10};

  /// A page asks for what is for it alone.  False: too many do.
  bool expect(std::int64_t viewer, WallTime now);
  /// What is for a page that did not ask, or for none that is known here, is dropped.
  void take(TopicMessage message, WallTime now);
  void forget_silent(WallTime now);

  /// All that came after a revision; 0: all there is.  Pages that are equally far, and asked for nothing,
  /// share one frame.
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
