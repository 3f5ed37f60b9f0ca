#include "hil_tests/deterministic/clock_events.hpp"

#include <algorithm>

#include "common/bus/clock_messages.hpp"
#include "common/clock/clock_map.hpp"

namespace roadbalance::test {

void ClockEvents::given(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  given_.push_back({channel, bytes});
}

void ClockEvents::durable(std::size_t count) {
  for (; durable_ < count; ++durable_) given_[durable_].durable = true;
}

bool ClockEvents::is_same(std::size_t at, std::string_view channel,
                          std::span<const std::uint8_t> bytes) const {
  return given_[at].channel == channel && std::ranges::equal(given_[at].bytes, bytes);
}

void ClockEvents::found(std::size_t at) {
  ++found_;
  const auto fit = decode_clock_fit(given_[at].bytes);
  if (!fit) {
    at_beginning_ = false;
    return;
  }
  if (at_beginning_) in_segment_.insert(at);
  Fits& fits = fits_[{fit->node, fit->epoch}];
  fits.last = at;
  if (!fit->is_known()) return;
  auto& known = fits.known;
  known.emplace_back(at, fit->host_ns);
  while (known.size() > 2 && fit->host_ns - known[1].second >= ClockMap::kBacklog_ns)
    known.erase(known.begin());
}

std::set<std::size_t> ClockEvents::may_be_said_again(const Fits& fits) {
  const auto& known = fits.known;
  std::set<std::size_t> may{fits.last};
  for (std::size_t k = 0; k < known.size(); ++k) {
    if (k + 2 >= known.size()) may.insert(known[k].first);
    if (k > 0 && known[k].second - known[k - 1].second > ClockMap::kHole_ns)
      may.insert({known[k - 1].first, known[k].first});
  }
  return may;
}

bool ClockEvents::is_repeated(std::string_view channel, std::span<const std::uint8_t> bytes) {
  const auto fit = decode_clock_fit(bytes);
  if (!fit || !at_beginning_) return false;
  const auto fits = fits_.find({fit->node, fit->epoch});
  if (fits == fits_.end()) return false;
  for (const std::size_t at : may_be_said_again(fits->second))
    if (is_same(at, channel, bytes)) return in_segment_.insert(at).second;
  return false;
}

void ClockEvents::pass_over(std::size_t behind) {
  for (; next_ < behind; ++next_)
    if (given_[next_].durable)
      truth_.fault("clock event " + std::to_string(next_ + 1) + ", " + given_[next_].channel +
                   ", came before a block that was called durable, and is not in the record");
}

void ClockEvents::take(int segment, std::string_view channel, std::span<const std::uint8_t> bytes) {
  if (!channel.starts_with("RB_CLOCK_")) return;
  if (segment != segment_) {
    segment_ = segment;
    at_beginning_ = true;
    in_segment_.clear();
  }
  for (std::size_t at = next_; at < given_.size(); ++at) {
    if (!is_same(at, channel, bytes)) continue;
    pass_over(at);
    ++next_;
    return found(at);
  }
  if (!is_repeated(channel, bytes))
    truth_.fault("a clock event on " + std::string(channel) +
                 " is in the record twice, out of order or never given");
}

void ClockEvents::finish() {
  pass_over(given_.size());
}

}  // namespace roadbalance::test
