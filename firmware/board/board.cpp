#include "firmware/board/board.hpp"

namespace roadbalance::board {

void Board::scan(const ScanWords& words, std::uint16_t overload, std::uint64_t ticks) {
  if (control_.state() == State::kArmed && control_.armed().mode == StartMode::kFollower) {
    encoders_.keep_from_now();
    control_.set_state(State::kRunning);
  }
  if (control_.state() != State::kRunning) return;
  encoders_.pass(ticks);
  if (!samples_.add(words, overload, ticks)) control_.set_state(State::kLost);
}

// A follower's wheels are followed before its master starts it, so that its first references are good.
bool Board::takes_edges() const {
  const State state = control_.state();
  return state == State::kRunning ||
         (state == State::kArmed && control_.armed().mode == StartMode::kFollower);
}

void Board::line_change(std::size_t line, Signal signal, bool high, std::uint64_t ticks) {
  if (!takes_edges()) return;
  if (const auto edge = encoders_.line_change(line, signal, high, ticks)) references_.follow(*edge);
}

void Board::update_references(std::uint64_t ticks) {
  if (!takes_edges()) return;
  hardware_.write_references(references_.codes(ticks));
}

std::optional<std::size_t> Board::control_request(const SetupPacket& setup,
                                                  std::span<const std::uint8_t> data,
                                                  std::span<std::uint8_t> reply) {
  Status counters;
  counters.scans_lost = samples_.lost();
  counters.scans_missed = samples_.missed();
  counters.edges_lost = encoders_.lost();
  counters.overloads = samples_.overloads();
  counters.glitches = samples_.glitches();
  counters.packets = packetizer_.packets();
  counters.scans = packetizer_.next_scan();
  counters.ticks = hardware_.ticks();

  const Control::Answer answer = control_.handle(setup, data, counters, reply);
  if (answer.refusal != Refusal::kNone) return std::nullopt;
  switch (answer.event) {
    case Control::Event::kNone:
      break;
    case Control::Event::kArmed:
      if (control_.armed().mode != StartMode::kFollower) break;
      begin_run();
      hardware_.start(StartMode::kFollower);
      break;
    case Control::Event::kStarted:
      begin_run();
      encoders_.keep_from_now();
      control_.set_state(State::kRunning);
      hardware_.start(control_.armed().mode);
      break;
    case Control::Event::kStopped:
      hardware_.stop();
      break;
  }
  return answer.reply;
}

void Board::begin_run() {
  const Configuration& configuration = control_.configuration();
  const std::uint32_t tick_hz = control_.identity().tick_hz;
  samples_.start({.ticks_per_scan = configuration.ticks_per_scan,
                  .loop_back = configuration.references_on != 0,
                  .pattern = control_.pattern()});
  encoders_.start(configuration.encoder, hardware_);
  references_.start(control_.references(), configuration, tick_hz);
  packetizer_.start({.token = control_.armed().token,
                     .tick_hz = tick_hz,
                     .ticks_per_scan = configuration.ticks_per_scan,
                     .limit_us = configuration.packet_limit_us,
                     .pattern = control_.pattern() != Pattern::kOff},
                    hardware_.ticks());
}

void Board::reset() {
  hardware_.stop();
  control_.reset();
}

std::size_t Board::next_packet(std::span<std::uint8_t> packet) {
  const State state = control_.state();
  if (state != State::kRunning && state != State::kLost) return 0;
  const bool empty = samples_.queue().size() == 0 && encoders_.queue().size() == 0;
  if (state == State::kLost && empty) return 0;
  return packetizer_.next(hardware_.ticks(), samples_, encoders_, references_.locked(), packet);
}

}  // namespace roadbalance::board
