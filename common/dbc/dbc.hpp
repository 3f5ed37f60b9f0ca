#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/dbc/can_signal.hpp"

namespace roadbalance {

/// A code with a name, e.g. 65535 "not available" (VAL_).
struct DbcCode {
  double raw = 0.0;  ///< before scale and offset
  std::string meaning;
};

/// SG_: one signal of a message.
struct DbcSignal {
  std::string name;
  std::string unit;
  int line = 0;  ///< of the file
  CanSignal place;
  double low = 0.0, high = 0.0;  ///< range of the value; both 0: none is given
  std::vector<DbcCode> codes;
  bool is_multiplexor = false;             ///< the message's multiplexor ("M")
  std::optional<std::uint64_t> when_bits;  ///< in the frame only while the multiplexor has these bits ("m3")

  bool has_range() const { return low != 0.0 || high != 0.0; }
};

/// BO_: the frames of one identifier.
struct DbcMessage {
  std::string name;
  int line = 0;
  std::uint32_t id = 0;
  bool extended = false;
  std::string sender = {};  ///< the node that sends it
  std::size_t size = 0;  ///< bytes; above 64 for what a transport protocol puts together from several frames
  std::vector<DbcSignal> signals;

  /// Nothing if there is none of that name.
  const DbcSignal* signal(std::string_view signal_name) const;
  /// Nothing if it is not multiplexed.
  const DbcSignal* multiplexor() const;
};

/// The frames and signals that a DBC file describes.
///
/// Read: BO_, SG_ (both byte orders, signs, scale, offset, range, unit, simple multiplexing), VAL_,
/// SIG_VALTYPE_. Every other section is passed over to its ';'.  Signals of the file's pseudo-message for
/// unused signals are left out. Extended multiplexing (m0M, SG_MUL_VAL_) is refused.
struct Dbc {
  static constexpr std::size_t kMostBytes = 16 << 20;
  static constexpr std::size_t kMostMessages = 10'000;
  static constexpr std::size_t kMostSignals = 1'000;  ///< of one message
  static constexpr std::size_t kMostCodes = 10'000;   ///< of one signal

  std::string file;  ///< for errors
  std::vector<DbcMessage> messages;

  /// @throws ConfigError "file:line: expected ..., found ..."
  static Dbc parse(std::string_view text, const std::string& name_for_errors);
  /// @throws also std::system_error if it cannot be read
  static Dbc read_file(const std::string& path);

  /// Nothing if there is none of that name.
  const DbcMessage* message(std::string_view name) const;
};

}  // namespace roadbalance
