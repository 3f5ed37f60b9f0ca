#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "common/record/log_event.hpp"

namespace roadbalance {

/// The sum of events that a commit event carries: see commit_t.lcm.
struct HeaderSum {
  std::uint64_t from = 0;  ///< offset in the segment
  std::uint32_t crc = 0;

  /// @param header  as encode_log_header() gives it
  void add(std::span<const std::uint8_t> header, std::string_view channel,
           std::span<const std::uint8_t> data);
};

/// Compares number, stamp and channel of each event of a record, and the contents of those that are no
/// blocks of nodes, with the sums of the commit events.  A sum of the headers alone is as good: so it was up
/// to format 3.
///
/// Events behind the last commit of a segment are not covered: that commit itself, and those that a kill
/// left.
class HeaderCheck {
 public:
  /// Events as they lie in the record.
  /// @return  at a commit, if its sum differs: the offset from which on something is altered
  std::optional<std::uint64_t> take(int segment, std::uint64_t offset, const LogEvent& event);

  /// The sum that a commit behind the events taken must carry.
  const HeaderSum& sum() const { return sum_; }

 private:
  int segment_ = 0;
  std::uint64_t next_ = 0;  // where the next event begins if nothing between is damaged
  bool whole_ = true;       // since sum_.from; else what is not is listed elsewhere
  HeaderSum sum_;
  std::uint32_t headers_crc_ = 0;  // of the same events without contents
};

}  // namespace roadbalance
