#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/types/clocks.hpp"
#include "common/types/control.hpp"

namespace roadbalance {

/// The nodes that are on the bus: those whose heartbeat was heard within the last 3 s.  One that has sent its
/// last heartbeat has left; it returns within a second or so if that was the end of a recording.
class HeardNodes {
 public:
  /// @param ours  whom to listen to; empty: everybody
  explicit HeardNodes(const std::vector<std::int32_t>& ours) : ours_(ours) {}

  /// A heartbeat as it came; what is none is left aside.
  void take(std::span<const std::uint8_t> bytes, WallTime now);

  int count(WallTime now);
  /// The last of each that is there.
  std::vector<Heartbeat> heartbeats(WallTime now);
  std::vector<std::int32_t> nodes(WallTime now);
  /// Those that left within the last 3 s.
  std::vector<std::int32_t> left(WallTime now);

  /// For people: a node that measures by another vehicle file than `file`; empty: none.
  std::string who_differs(std::uint32_t vehicle_crc32c, const std::string& file) const;

 private:
  void forget(WallTime now);

  struct Heard {
    WallTime at{};
    Heartbeat beat{};
    bool has_left = false;
  };
  std::vector<std::int32_t> nodes_that(bool have_left, WallTime now);
  const std::vector<std::int32_t>& ours_;
  std::map<std::int32_t, Heard> heard_;
};

}  // namespace roadbalance
