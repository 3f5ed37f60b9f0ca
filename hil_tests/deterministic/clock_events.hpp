#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/record/recorded_clocks.hpp"
#include "hil_tests/deterministic/truth.hpp"

namespace roadbalance::test {

/// Holds the clock exchanges and fits of one recorder's record against those that it was given.
///
/// They stand in the record in their order, each once; what came before a block that was called durable is
/// there; a recorder that dies may lose any later ones.  A segment's preamble, before anything
/// new of them, repeats the pair of clocks and of epochs that have not ended the fits that
/// RecordedClocks::events() demands, and nothing else, so that who begins with it places their instants as
/// who has read all.
class ClockEvents {
 public:
  explicit ClockEvents(Truth& truth) : truth_(truth) {}

  /// The recorder keeps this from now on.
  void given(const std::string& channel, const std::vector<std::uint8_t>& bytes);
  std::size_t count() const { return passed_ + given_.size(); }
  /// The first `count` are on the disk, but for what died with a recorder.
  void durable(std::size_t count);
  /// It died, and with it what was not durable.
  void died() { durable_ = count(); }

  /// The record goes on in a segment, of which the next events are.
  /// @param number  1: before it there is nothing
  /// @param has_ended  whether an epoch has ended, by the record so far
  void begin_segment(int number, const std::function<bool(const NodeEpoch&)>& has_ended);
  /// The next event of the record; those of other channels are passed over.
  void take(std::string_view channel, std::span<const std::uint8_t> bytes);
  /// The record has no more.
  void finish();

  std::int64_t found() const { return found_; }

 private:
  struct Event {
    std::string channel;
    std::vector<std::uint8_t> bytes;
    bool durable = false;
  };
  bool is_given(std::string_view channel, std::span<const std::uint8_t> bytes);
  void pass_over(std::size_t given);
  void end_preamble();
  void end_segment();

  Truth& truth_;
  std::deque<Event> given_;  // from the one on that is expected next in the record
  std::size_t passed_ = 0;   // before it
  std::size_t durable_ = 0;  // decided
  std::int64_t found_ = 0;
  RecordedClocks all_, of_segment_;
  std::set<NodeEpoch> ended_;                                     // before the segment
  std::set<std::pair<NodeEpoch, std::int64_t>> fits_of_segment_;  // of the others, with their node's instant
  RecordEvents preamble_;                                         // those that it has not repeated yet
};

}  // namespace roadbalance::test
