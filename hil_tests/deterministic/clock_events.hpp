#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/clock/exchange.hpp"
#include "hil_tests/deterministic/truth.hpp"

namespace roadbalance::test {

/// Holds the clock exchanges and fits of one recorder's record against those that it was given.
///
/// They stand in the record in their order, each once; what came before a block that was called durable is
/// there, of what came behind it a recorder that dies may lose any.  Before its first exchange a segment says
/// again, each once, fits that stand in the record: of an epoch the last one, the last two that are known and
/// both sides of a hole that ended a minute ago at most.
class ClockEvents {
 public:
  explicit ClockEvents(Truth& truth) : truth_(truth) {}

  /// The recorder keeps this from now on.
  void given(const std::string& channel, const std::vector<std::uint8_t>& bytes);
  std::size_t count() const { return given_.size(); }
  /// The first `count` are on the disk, but for what died with a recorder.
  void durable(std::size_t count);
  /// It died, and with it what was not durable.
  void died() { durable_ = given_.size(); }

  /// The next event of the record, in the segment of this number; those of other channels are passed over.
  void take(int segment, std::string_view channel, std::span<const std::uint8_t> bytes);
  /// The record has no more.
  void finish();

  std::int64_t found() const { return found_; }

 private:
  struct Event {
    std::string channel;
    std::vector<std::uint8_t> bytes;
    bool durable = false;
  };
  /// The fits of an epoch that stand in the record, as far as they may be said again: of given_, with the
  /// host's instants.
  struct Fits {
    std::size_t last = 0;
    std::vector<std::pair<std::size_t, std::int64_t>> known;  // but for the first, of the last minute
  };
  bool is_same(std::size_t at, std::string_view channel, std::span<const std::uint8_t> bytes) const;
  void found(std::size_t at);
  static std::set<std::size_t> may_be_said_again(const Fits& fits);
  bool is_repeated(std::string_view channel, std::span<const std::uint8_t> bytes);
  void pass_over(std::size_t behind);

  Truth& truth_;
  std::vector<Event> given_;
  std::size_t durable_ = 0;  // of given_: decided
  std::size_t next_ = 0;     // of given_: expected in the record
  std::int64_t found_ = 0;
  std::map<std::pair<std::int32_t, std::int64_t>, Fits> fits_;  // by (node, epoch)
  int segment_ = 0;
  bool at_beginning_ = false;         // of the segment
  std::set<std::size_t> in_segment_;  // of given_: fits, until the beginning is over
};

}  // namespace roadbalance::test
