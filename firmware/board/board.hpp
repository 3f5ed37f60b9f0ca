#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "firmware/board/control.hpp"
#include "firmware/board/encoder_capture.hpp"
#include "firmware/board/hardware.hpp"
#include "firmware/board/packetizer.hpp"
#include "firmware/board/reference_generator.hpp"
#include "firmware/board/sample_ring.hpp"

namespace roadbalance::board {

/// The front-end board's firmware, without its hardware layer.
///
/// Needs no heap, exceptions, RTTI or operating system; all memory is in the object (about 170 kB).  Hardware
/// describes which function is called from where.
class Board {
 public:
  Board(const Identity& identity, Hardware& hardware) : hardware_(hardware), control_(identity, hardware) {}

  /// Interrupt: a conversion was done at `ticks`.
  /// @param overload  bit k: the analogue part of channel k was overloaded since the last conversion
  void scan(const ScanWords& words, std::uint16_t overload, std::uint64_t ticks);

  /// Interrupt: an encoder's input changed to this level at `ticks`.
  void line_change(std::size_t line, Signal signal, bool high, std::uint64_t ticks);

  /// Interrupt: writes the D/A for the wheels' angles at `ticks`: the middle of the time the codes will
  /// stand.
  void update_references(std::uint64_t ticks);

  /// Main loop: a vendor request.  Returns the bytes of the reply, or nothing: stall.
  std::optional<std::size_t> control_request(const SetupPacket& setup, std::span<const std::uint8_t> data,
                                             std::span<std::uint8_t> reply);

  /// Main loop: as after power-up.  For a bus reset, SET_CONFIGURATION and unplugging.
  void reset();

  /// Main loop, whenever the bulk endpoint is free: the next packet if one is due.  Returns its size, or 0.
  /// @param packet  room for kMaxPacketBytes
  std::size_t next_packet(std::span<std::uint8_t> packet);

  State state() const { return control_.state(); }

 private:
  bool takes_edges() const;
  void begin_run();

  Hardware& hardware_;
  Control control_;
  SampleRing samples_;
  EncoderCapture encoders_;
  ReferenceGenerator references_;
  Packetizer packetizer_;
};

}  // namespace roadbalance::board
