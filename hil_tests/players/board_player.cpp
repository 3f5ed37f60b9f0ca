#include "hil_tests/players/board_player.hpp"

#include <cmath>
#include <utility>

namespace roadbalance::test {
namespace {

constexpr std::uint32_t kWordMask = (1U << 24) - 1;

}  // namespace

BoardPlayer::BoardPlayer(NodeDrive drive, std::vector<DriveLevel> capture, Timetable timetable)
    : drive_(std::move(drive)),
      capture_(std::move(capture)),
      timetable_(timetable),
      begin_(timetable.at(drive_.first_scan())) {}

Bench BoardPlayer::bench(const std::string& serial) {
  Bench bench;
  bench.serial = serial;
  bench.oscillator_ppm = drive_.converter_ppm;
  bench.begin = [this](MachineTime asked, Nanoseconds period) { return run_begin(asked, period); };
  bench.words = [this](std::int64_t, MachineTime time) { return words(time); };
  bench.next_change = [this] { return next_change(); };
  return bench;
}

MachineTime BoardPlayer::run_begin(MachineTime asked, Nanoseconds period) {
  period_ = period;
  const double periods = std::floor((begin_ - asked) / period);
  return begin_ - MachineClock::duration(std::llround(periods * period.count()));
}

board::ScanWords BoardPlayer::words(MachineTime time) {
  board::ScanWords words{};
  const auto scan = std::llround((time - begin_) / period_);
  if (scan < 0 || scan >= static_cast<std::int64_t>(drive_.scans.size())) return words;
  const Scan& played = drive_.scans[static_cast<std::size_t>(scan)];
  for (std::size_t k = 0; k < played.counts.size(); ++k)
    words[k] = static_cast<std::uint32_t>(played.counts[k]) & kWordMask;
  if (scan == played_.load(std::memory_order_relaxed)) played_.store(scan + 1, std::memory_order_relaxed);
  return words;
}

std::optional<LineChange> BoardPlayer::next_change() {
  if (next_level_ == capture_.size()) return std::nullopt;
  const DriveLevel& level = capture_[next_level_++];
  return LineChange{timetable_.at(level.time), level.wire / std::size_t{2},
                    level.wire % 2 == 0 ? board::Signal::kA : board::Signal::kZero, level.high};
}

}  // namespace roadbalance::test
