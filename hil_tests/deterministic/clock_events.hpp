#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hil_tests/deterministic/truth.hpp"

namespace roadbalance::test {

/// Holds the clock exchanges and fits of one recorder's record against those that it was given.
///
/// They stand in the record in their order, each once; what came before a block that was called durable is
/// there, of what came behind it a recorder that dies may lose any.  Fits are said again at the beginning of
/// a segment: the last one of an epoch, and one before that.  Compares bytes and decodes nothing.
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
  bool is_repeated(std::string_view channel, std::span<const std::uint8_t> bytes) const;
  void pass_over(std::size_t behind);

  Truth& truth_;
  std::vector<Event> given_;
  std::size_t durable_ = 0;  // of given_: decided
  std::size_t next_ = 0;     // of given_: expected in the record
  std::int64_t found_ = 0;
};

}  // namespace roadbalance::test
