#include "hil_tests/deterministic/clock_events.hpp"

#include <algorithm>

namespace roadbalance::test {
namespace {

// A segment says at most two fits of an epoch again; between these lie those of the other nodes, and
// exchanges.
constexpr std::size_t kLookBack = 4096;

}  // namespace

void ClockEvents::given(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  given_.push_back({channel, bytes});
}

void ClockEvents::durable(std::size_t count) {
  for (; durable_ < count; ++durable_) given_[durable_].durable = true;
}

bool ClockEvents::is_repeated(std::string_view channel, std::span<const std::uint8_t> bytes) const {
  if (channel.starts_with("RB_CLOCK_EXCHANGE_")) return false;
  const auto end = given_.begin() + static_cast<std::ptrdiff_t>(next_);
  const auto begin = end - static_cast<std::ptrdiff_t>(std::min(next_, kLookBack));
  return std::any_of(begin, end, [&](const Event& event) {
    return event.channel == channel && std::ranges::equal(event.bytes, bytes);
  });
}

void ClockEvents::pass_over(std::size_t behind) {
  for (; next_ < behind; ++next_)
    if (given_[next_].durable)
      truth_.fault("clock event " + std::to_string(next_ + 1) + ", " + given_[next_].channel +
                   ", came before a block that was called durable, and is not in the record");
}

void ClockEvents::take(std::string_view channel, std::span<const std::uint8_t> bytes) {
  if (!channel.starts_with("RB_CLOCK_")) return;
  for (std::size_t at = next_; at < given_.size(); ++at) {
    if (given_[at].channel != channel || !std::ranges::equal(given_[at].bytes, bytes)) continue;
    pass_over(at);
    ++next_;
    ++found_;
    return;
  }
  if (!is_repeated(channel, bytes))
    truth_.fault("a clock event on " + std::string(channel) +
                 " is in the record twice, out of order or never given");
}

void ClockEvents::finish() {
  pass_over(given_.size());
}

}  // namespace roadbalance::test
