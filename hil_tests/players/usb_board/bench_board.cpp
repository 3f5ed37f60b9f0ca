#include "hil_tests/players/usb_board/bench_board.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace roadbalance::test {
namespace {

/// A main loop that has nothing to send looks again after this.
constexpr auto kIdle = std::chrono::milliseconds(5);
constexpr std::int32_t kFullScale = 1 << 23;

board::Identity identity_of(const Bench& bench) {
  board::Identity identity;
  identity.major = bench.major;
  identity.minor = bench.minor;
  identity.firmware_version = 0x010000;
  std::copy_n(bench.serial.begin(), std::min(bench.serial.size(), identity.serial.size()),
              identity.serial.begin());
  identity.capabilities =
      board::kHasReferences | board::kHasQuadrature | board::kHasSync | board::kHasTestPattern;
  identity.tick_hz = BenchBoard::kTickHz;
  identity.rate_min_hz = 100;
  identity.rate_max_hz = 20'000;
  identity.filter_min_hz = 10;
  identity.filter_max_hz = 5000;
  identity.filter_orders = 1u << 4 | 1u << 6 | 1u << 8;
  identity.full_scale_uv = {10'000'000, 5'000'000, 2'500'000, 1'250'000};
  return identity;
}

}  // namespace

BenchBoard::BenchBoard(Bench bench)
    : bench_(std::move(bench)),
      board_(std::make_unique<board::Board>(identity_of(bench_), static_cast<board::Hardware&>(*this))) {
  if (bench_.next_change) change_ = bench_.next_change();
}

BenchBoard::Nanoseconds BenchBoard::tick() const {
  return Nanoseconds(1e9 / (kTickHz * (1.0 + 1e-6 * bench_.oscillator_ppm)));
}

std::uint64_t BenchBoard::ticks_at(MachineTime time) const {
  return static_cast<std::uint64_t>((time - bench_.powered) / tick());
}

MachineTime BenchBoard::time_of(std::uint64_t ticks) const {
  return bench_.powered + MachineClock::duration(std::llround(static_cast<double>(ticks) * tick().count()));
}

bool BenchBoard::configure(const board::Configuration& configuration) {
  configuration_ = configuration;
  return true;
}

void BenchBoard::start(board::StartMode mode) {
  running_ = true;
  if (starts_to_come_ > 0) --starts_to_come_;
  mode_ = mode;
  start_ticks_ =
      bench_.begin ? ticks_at(bench_.begin(now_, tick() * configuration_.ticks_per_scan)) : ticks();
  conversions_ = 0;
  unsent_since_.reset();
  codes_ = {};
}

bool BenchBoard::level(std::size_t line, board::Signal signal) const {
  return level_[line][static_cast<std::size_t>(signal)];
}

MachineTime BenchBoard::conversion_time(std::int64_t k) const {
  return time_of(start_ticks_ + static_cast<std::uint64_t>(k + 1) * configuration_.ticks_per_scan);
}

void BenchBoard::change_lines(std::uint64_t until_ticks) {
  // By stamps: what shares a conversion's tick comes before it, as board::Hardware demands.
  while (change_ && (change_->time <= bench_.powered || ticks_at(change_->time) <= until_ticks)) {
    level_[change_->line][static_cast<std::size_t>(change_->signal)] = change_->high;
    if (running_) board_->line_change(change_->line, change_->signal, change_->high, ticks_at(change_->time));
    change_ = bench_.next_change();
  }
}

void BenchBoard::convert(MachineTime time) {
  const bool exact = mode_ != board::StartMode::kFollower;
  const std::uint64_t period = configuration_.ticks_per_scan;
  const std::uint64_t stamp =
      exact ? start_ticks_ + static_cast<std::uint64_t>(conversions_ + 1) * period : ticks_at(time);
  change_lines(stamp);
  now_ = std::max(now_, time);
  board::ScanWords words{};
  if (bench_.words) words = bench_.words(conversions_, time);
  if (configuration_.references_on)
    for (std::size_t k = 0; k < codes_.size(); ++k)
      words[board::kInputChannels + k] = static_cast<std::uint32_t>(
          std::lround(codes_[k] * (kFullScale / board::ReferenceGenerator::kFullScaleCode)));
  board_->scan(words, 0, stamp);
  if (configuration_.references_on) board_->update_references(stamp + period / 2);
  bounce(stamp);
  ++conversions_;
  if (!unsent_since_) unsent_since_ = time;
}

/// A conversion beside the true ones: what it gives is none of the bench's words.
void BenchBoard::bounce(std::uint64_t stamp) {
  const auto part = bench_.bounces ? bench_.bounces(conversions_) : std::nullopt;
  if (!part) return;
  const std::uint64_t bounced = stamp + static_cast<std::uint64_t>(*part * configuration_.ticks_per_scan);
  change_lines(bounced);
  board_->scan({}, 0, bounced);
}

std::size_t BenchBoard::next_packet(std::span<std::uint8_t> packet) {
  const std::size_t size = board_->next_packet(packet);
  if (size > 0) unsent_since_.reset();
  return size;
}

void BenchBoard::advance(MachineTime now) {
  const bool converts = starts_to_come_ == 0 && mode_ != board::StartMode::kFollower;
  while (running_ && converts && conversion_time(conversions_) <= now) {
    const MachineTime time = conversion_time(conversions_);
    convert(time);
    if (mode_ == board::StartMode::kMaster && follower_ && follower_->running_) follower_->convert(time);
  }
  change_lines(ticks_at(now));
  now_ = std::max(now_, now);
}

std::optional<std::size_t> BenchBoard::control_request(const board::SetupPacket& setup,
                                                       std::span<const std::uint8_t> data,
                                                       std::span<std::uint8_t> reply) {
  return board_->control_request(setup, data, reply);
}

MachineTime BenchBoard::due() const {
  const MachineTime idle = now_ + kIdle;
  if (!running_ || !unsent_since_) return idle;
  return std::min(idle, *unsent_since_ + std::chrono::microseconds(configuration_.packet_limit_us));
}

}  // namespace roadbalance::test
