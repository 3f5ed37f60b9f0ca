#include "hil_tests/deterministic/clock_events.hpp"

#include <algorithm>

#include "common/bus/clock_messages.hpp"
#include "common/bus/notes.hpp"

namespace roadbalance::test {

void ClockEvents::given(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  given_.push_back({channel, bytes});
}

void ClockEvents::durable(std::size_t count) {
  for (; durable_ < count; ++durable_)
    if (durable_ >= passed_) given_[durable_ - passed_].durable = true;
}

void ClockEvents::pass_over(std::size_t given) {
  for (; given > 0; --given, ++passed_) {
    if (given_.front().durable)
      truth_.fault("clock event " + std::to_string(passed_ + 1) + ", " + given_.front().channel +
                   ", came before a block that was called durable, and is not in the record");
    given_.pop_front();
  }
}

// Those before it that are not in the record were lost.
bool ClockEvents::is_given(std::string_view channel, std::span<const std::uint8_t> bytes) {
  const auto at = std::ranges::find_if(given_, [&](const Event& event) {
    return event.channel == channel && std::ranges::equal(event.bytes, bytes);
  });
  if (at == given_.end()) return false;
  pass_over(static_cast<std::size_t>(at - given_.begin()));
  given_.pop_front();
  ++passed_;
  ++found_;
  return true;
}

void ClockEvents::begin_segment(int number, const std::function<bool(const NodeEpoch&)>& has_ended) {
  end_segment();
  if (number == 1) all_ = {};
  of_segment_ = {};
  ended_.clear();
  preamble_ = all_.events([&](const NodeEpoch& key) {
    if (has_ended(key)) ended_.insert(key);
    return !ended_.contains(key);
  });
}

void ClockEvents::end_preamble() {
  for (const auto& [channel, bytes] : std::exchange(preamble_, {}))
    truth_.fault("a segment's preamble lacks what is known of the clocks from " + channel);
}

void ClockEvents::end_segment() {
  end_preamble();
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  for (const auto& [key, node_ns] : std::exchange(fits_of_segment_, {}))
    for (const std::int64_t late_s : {0, 1, 10, 60}) {
      const std::int64_t instant_ns = node_ns - late_s * kSecond_ns;
      if (all_.host_ns(key, instant_ns) == of_segment_.host_ns(key, instant_ns)) continue;
      return truth_.fault("who begins with a segment places an instant of node " + std::to_string(key.first) +
                          " otherwise than who has read all of the record");
    }
}

void ClockEvents::take(std::string_view channel, std::span<const std::uint8_t> bytes) {
  const bool is_note = channel == kNoteChannel;
  if (!is_note && !channel.starts_with(kClockChannels)) return;
  const auto fit = decode_clock_fit(bytes);
  const bool is_new = all_.take(channel, bytes).has_value();
  static_cast<void>(of_segment_.take(channel, bytes));
  if (fit && !ended_.contains({fit->node, fit->epoch}))
    fits_of_segment_.insert({{fit->node, fit->epoch}, fit->node_ns});
  if (!is_note && is_given(channel, bytes)) {
    end_preamble();
    if (fit && !is_new) truth_.fault("who reads the record passes over a fit on " + std::string(channel));
    return;
  }
  const auto again = std::ranges::find_if(preamble_, [&](const auto& event) {
    return event.first == channel && std::ranges::equal(event.second, bytes);
  });
  if (again != preamble_.end())
    preamble_.erase(again);
  else if (!is_note)
    truth_.fault("a clock event on " + std::string(channel) +
                 " is in the record twice, out of order or never given");
}

void ClockEvents::finish() {
  end_segment();
  pass_over(given_.size());
}

}  // namespace roadbalance::test
