#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "firmware/board/hardware.hpp"
#include "firmware/board/protocol.hpp"

namespace roadbalance::board {

/// The eight bytes that begin a USB control transfer.
struct SetupPacket {
  std::uint8_t request_type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  std::uint16_t length = 0;
};

/// The board's states and set-up, as the host's requests change them.
///
/// A request is carried out or refused as a whole: refused, it changes nothing but Status's count of
/// refusals.
class Control {
 public:
  enum class Event : std::uint8_t { kNone, kArmed, kStarted, kStopped };
  struct Answer {
    Refusal refusal = Refusal::kNone;  ///< else the transfer is stalled
    std::size_t reply = 0;             ///< bytes written
    Event event = Event::kNone;
  };

  Control(const Identity& identity, Hardware& hardware) : identity_(identity), hardware_(hardware) {}

  /// @param data      of an OUT transfer, setup.length bytes
  /// @param counters  the Status to answer with; Control fills in its own part
  /// @param reply     of an IN transfer; cut at its size and setup.length
  Answer handle(const SetupPacket& setup, std::span<const std::uint8_t> data, const Status& counters,
                std::span<std::uint8_t> reply);

  /// As after power-up.
  void reset();

  /// The run's state; interrupts, too, may change it from armed to running to lost.
  State state() const { return state_.load(std::memory_order_acquire); }
  void set_state(State state) { state_.store(state, std::memory_order_release); }

  const Identity& identity() const { return identity_; }
  const Configuration& configuration() const { return configuration_; }
  const ReferenceSetup& references() const { return references_; }
  Pattern pattern() const { return pattern_; }
  const Arm& armed() const { return armed_; }

 private:
  Answer answer_in(const SetupPacket& setup, const Status& counters, std::span<std::uint8_t> reply) const;
  Answer take_out(const SetupPacket& setup, std::span<const std::uint8_t> data);
  Refusal configure(std::span<const std::uint8_t> data);
  Refusal set_references(std::span<const std::uint8_t> data);
  Refusal set_pattern(std::span<const std::uint8_t> data);
  Refusal arm(std::span<const std::uint8_t> data);
  Refusal start(std::span<const std::uint8_t> data);
  Refusal checked(const Configuration& wanted) const;

  Identity identity_;
  Hardware& hardware_;
  std::atomic<State> state_ = State::kIdle;
  bool configured_ = false;
  Configuration configuration_;
  ReferenceSetup references_;
  Pattern pattern_ = Pattern::kOff;
  Arm armed_;
  std::uint32_t refusals_ = 0;
  Refusal last_refusal_ = Refusal::kNone;
  std::uint8_t refused_request_ = 0;
};

}  // namespace roadbalance::board
