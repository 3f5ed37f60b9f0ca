#include "firmware/backends/gpio/edge_pump.hpp"

#include <algorithm>
#include <cstdint>
#include <thread>
#include <utility>

#include "common/config/section.hpp"
#include "common/types/clock_pair.hpp"

namespace roadbalance {
namespace {

constexpr std::int64_t kSlept_ns = 5'000'000;  // more than the system slews the one clock against the other
constexpr std::size_t kEventsHeld = 4096;      // 7 ms of two 1000-pulse transducers in quadrature are 3400

std::int64_t monotonic_now_ns() {
  return to_ns(WallClock::now());
}

}  // namespace

EdgePump::EdgePump(std::string chip, std::vector<GpioInput> inputs, EdgeStore& store, Warn warn)
    : chip_name_(std::move(chip)),
      store_(store),
      warn_(std::move(warn)),
      maker_(std::move(inputs), store.report),
      order_(kEventsHeld),
      waiting_(maker_.inputs().size()),
      was_full_(maker_.inputs().size()) {
  open();
  read_levels();
}

void EdgePump::open() {
  std::optional<GpioChip> chip;
  try {
    chip.emplace(chip_name_, identity_);
  } catch (const GpioError& error) {
    throw GpioError("front end " + store_.report.device() + ": " + error.what());
  }
  for (std::size_t k = 0; k < waiting_.size(); ++k) {
    const GpioInput& input = maker_.inputs()[k];
    const bool both = maker_.has_direction(input.line) && input.track != GpioTrack::kZeroMark;
    try {
      chip->take_edges(input.offset, both ? GpioChip::Edges::kBoth : GpioChip::Edges::kRising, "roadbalance");
    } catch (const GpioError& error) {
      throw ConfigError(input.key + ": " + error.what());
    }
  }
  std::fill(was_full_.begin(), was_full_.end(), false);
  if (identity_.label.empty()) identity_ = chip->identity();
  chip_ = std::move(chip);
}

void EdgePump::read_levels() noexcept {
  std::array<std::optional<bool>, kEncoderLines> tooth, direction;
  for (std::size_t k = 0; k < waiting_.size(); ++k) {
    const GpioInput& input = maker_.inputs()[k];
    if (input.track == GpioTrack::kTooth) tooth[input.line] = chip_->level(k);
    if (input.track == GpioTrack::kDirection) direction[input.line] = chip_->level(k);
  }
  for (std::uint8_t line = 0; line < kEncoderLines; ++line) maker_.start(line, tooth[line], direction[line]);
}

bool EdgePump::open_again() noexcept {
  retry_ns_ = monotonic_now_ns() + kRetry_ns;
  try {
    open();
    why_gone_.over();
    return true;
  } catch (const std::exception& error) {  // not there yet, or its file is but may not be opened yet
    if (why_gone_.is_due(error.what(), WallClock::now())) warn_(error.what());
    return false;
  }
}

void EdgePump::turn() noexcept {
  const std::int64_t before_ns = monotonic_now_ns();
  if (!chip_ && before_ns >= retry_ns_ && open_again()) {
    store_.report.count(DeviceCounter::kReturned);
    lose_all(before_ns);
    read_levels();
  }
  if (chip_)
    chip_->wait(kPatience, waiting_);
  else
    std::this_thread::sleep_for(kPatience);
  const std::int64_t known_ns =
      std::exchange(machine_minus_monotonic_ns_, machine_minus(CLOCK_MONOTONIC).count());
  if (known_ns != 0 && machine_minus_monotonic_ns_ - known_ns > kSlept_ns && chip_) return wake();
  if (!chip_) return complete_before(before_ns);  // nothing will come
  if (!read_waiting()) return;
  give_before(before_ns - kSettle_ns);
  complete_before(before_ns - kSettle_ns);
}

void EdgePump::complete_before(std::int64_t monotonic_ns) noexcept {
  store_.complete_ns.store(monotonic_ns + machine_minus_monotonic_ns_ - kClockReading_ns,
                           std::memory_order_release);
}

/// The computer has slept: the kernel's stamps do not show on which side of that an edge lies.
void EdgePump::wake() noexcept {
  const std::int64_t now_ns = monotonic_now_ns();
  for (std::size_t k = 0; k < waiting_.size(); ++k) {
    if (waiting_[k] == Waiting::kNothing) continue;
    if (waiting_[k] == Waiting::kGone || !chip_->read(k, event_)) return chip_is_gone();
  }
  give_before(INT64_MAX);
  lose_all(now_ns);
  read_levels();
  complete_before(now_ns - kSettle_ns);
}

/// True if all that came before the wait has been read.
bool EdgePump::read_waiting() noexcept {
  bool drained = true;
  for (std::size_t k = 0; k < waiting_.size(); ++k) {
    if (waiting_[k] == Waiting::kNothing) {
      was_full_[k] = false;
      continue;
    }
    const auto count = waiting_[k] == Waiting::kGone ? std::nullopt : chip_->read(k, event_);
    if (!count) {
      chip_is_gone();
      return false;
    }
    if (order_.room() <= *count) give_before(INT64_MAX);  // far behind: better in doubtful order than never
    put_events(k, *count);
    drained = drained && *count < event_.size();
  }
  return drained;
}

void EdgePump::put_events(std::size_t input, std::size_t count) noexcept {
  const std::uint8_t line = maker_.inputs()[input].line;
  InputEvent event{.machine_minus_monotonic_ns = machine_minus_monotonic_ns_,
                   .input = static_cast<std::uint8_t>(input)};
  for (std::size_t k = 0; k < count; ++k) {
    event.monotonic_ns = event_[k].monotonic_ns;
    event.kind = event_[k].rising ? InputEvent::kRising : InputEvent::kFalling;
    if (!order_.add(event)) drop(line, DeviceCounter::kLateEdges);
  }
  // Events that the kernel dropped came after those it kept: behind these, or behind those that come until
  // the line has been seen empty.
  const bool full = count == event_.size();
  event.kind = InputEvent::kLost;
  if ((full || was_full_[input]) && !order_.add(event)) drop(line, DeviceCounter::kLateEdges);
  was_full_[input] = full;
}

void EdgePump::give_before(std::int64_t monotonic_ns) noexcept {
  std::array<Edge, EdgeMaker::kMost> edges;
  while (const auto event = order_.take_before(monotonic_ns)) {
    const std::size_t count = maker_.take(*event, edges);
    for (std::size_t k = 0; k < count; ++k) store(edges[k]);
  }
}

void EdgePump::drop(std::uint8_t line, DeviceCounter why) noexcept {
  if (dropped_.drop(line)) store_.report.count(why);
}

void EdgePump::store(const Edge& edge) noexcept {
  // Edges are a nanosecond apart or more, so that before the first one after dropped ones there is time for
  // the mark.
  if (!dropped_.pass(edge, [this](const Edge& kept) { return store_.edges.push(kept); }))
    drop(edge.line, DeviceCounter::kReadersTooSlow);
}

void EdgePump::lose_all(std::int64_t monotonic_ns) noexcept {
  const NodeTime now = node_time_from_ns(monotonic_ns + machine_minus_monotonic_ns_);
  std::array<bool, kEncoderLines> done{};
  for (const GpioInput& input : maker_.inputs())
    if (!std::exchange(done[input.line], true)) store(maker_.lost(input.line, now));
}

void EdgePump::chip_is_gone() noexcept {
  const std::int64_t now_ns = monotonic_now_ns();
  give_before(INT64_MAX);
  store_.report.count(DeviceCounter::kGone);
  lose_all(now_ns);
  chip_.reset();
  retry_ns_ = now_ns + kRetry_ns;
}

}  // namespace roadbalance
