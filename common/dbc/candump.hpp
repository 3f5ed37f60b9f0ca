#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/dbc/can_frame.hpp"

namespace roadbalance {

/// One frame of a log, with where and when it was received.
struct LoggedFrame {
  std::int64_t time_ns = 0;  ///< receiver's stamp
  std::string interface;     ///< e.g. "can0"
  CanFrame frame;
};

/// One line of the log format of candump -L: "(seconds.microseconds) interface ID#DATA", or of a CAN FD frame
/// "ID##FDATA" with one digit F of flags.
/// @return nothing if the line is anything else, e.g. a remote or error frame
std::optional<LoggedFrame> parse_candump(std::string_view line);

}  // namespace roadbalance
