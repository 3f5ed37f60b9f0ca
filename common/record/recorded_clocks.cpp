#include "common/record/recorded_clocks.hpp"

#include <algorithm>

#include "common/bus/clock_messages.hpp"
#include "common/types/bounded_time.hpp"

namespace roadbalance {

std::optional<ClockFit> RecordedClocks::take(std::string_view channel, std::span<const std::uint8_t> data) {
  if (channel == kNoteChannel) {
    const auto note = decode_note(data);
    // One that was taken before the host's clocks were read has none.
    if (note && note->time_us != 0) {
      // The host's clock begins anew with it: fits to the one before do not hold for this one.  An older pair
      // of the same recorder is only repeated; wall time may have been set back since.
      if (pair_ && note->incarnation > pair_->incarnation && note->host_ns < pair_->host_ns &&
          note->time_us > pair_->time_us)
        fits_ = {};
      pair_ = Note{.time_us = note->time_us,
                   .host_ns = note->host_ns,
                   .incarnation = note->incarnation,
                   .kind = NoteKind::kClock,
                   .text = {}};
    }
  } else if (channel.starts_with(kClockChannels)) {
    const auto fit = decode_clock_fit(data);
    if (fit && fits_.take(*fit)) return fit;
  }
  return std::nullopt;
}

std::optional<std::int64_t> RecordedClocks::host_ns(const NodeEpoch& key, std::int64_t node_ns) const {
  const auto row = fits_.rows().find(key);
  if (row == fits_.rows().end() || !row->second.known.is_known()) return std::nullopt;
  return row->second.known.host_time_ns(node_ns);
}

std::optional<std::int64_t> RecordedClocks::utc_us(std::int64_t host_ns) const {
  if (!pair_) return std::nullopt;
  return std::clamp(pair_->time_us + (bounded_ns(host_ns) - pair_->host_ns) / 1000, -kUtcLimit_us,
                    kUtcLimit_us);
}

RecordEvents RecordedClocks::events(const std::function<bool(const NodeEpoch&)>& wanted) const {
  RecordEvents events;
  if (pair_) events.emplace_back(kNoteChannel, encode(*pair_));
  for (const auto& [key, row] : fits_.rows()) {
    if (!wanted(key)) continue;
    const std::string channel = clock_fit_channel(key.first);
    for (const ClockFit& fit : row.known.fits()) events.emplace_back(channel, encode(fit));
    if (row.last != row.known.last()) events.emplace_back(channel, encode(row.last));
  }
  return events;
}

}  // namespace roadbalance
