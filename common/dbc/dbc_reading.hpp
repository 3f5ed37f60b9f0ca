#pragma once

#include "common/dbc/dbc.hpp"

namespace roadbalance {

/// The value of one signal in a frame of its message.
struct DbcReading {
  enum class Status {
    kOk,
    kAbsent,        ///< the frame carries the signals of another value of the multiplexor
    kTooShort,      ///< the frame has fewer bytes than its message
    kNotAvailable,  ///< a code for that, see below
    kOutOfRange,    ///< outside of the signal's range, or no number
  };
  Status status = Status::kOk;
  double value = 0.0;  ///< in the signal's unit; only if kOk
};

/// A value outside of the range is refused; half a count is left to rounding.  One that has a name (VAL_) is
/// no measurement if it lies outside of the range, or if there is no range but a unit: a number with neither
/// unit nor range is a choice whose values all have names.
DbcReading read_signal(const DbcMessage& message, const DbcSignal& signal, const CanFrame& frame) noexcept;

}  // namespace roadbalance
