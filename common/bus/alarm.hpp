#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace roadbalance {

/// How bad it is, in three levels.
enum class AlarmLevel : std::int32_t {
  kNotice = 1,   ///< to know; nothing suffers
  kWarning = 2,  ///< results suffer, or a loss threatens
  kAlarm = 3,    ///< something is lost for good, or nothing is recorded
};

/// Causes of an alarm; the meaning of Alarm::part stands in brackets.  The hundreds are the level: one
/// definition for recorder, page and command line.
enum class AlarmCause : std::int32_t {
  kFallback = 101,     ///< the recorder uses its fallback folder
  kWheelInStep = 102,  ///< it turned in step with another one (wheel 0..3, front_left ..)
  kSpoolFailing = 201,
  kDiskLow = 202,
  kDiskSlow = 203,
  kSupplyGone = 204,
  kSupplyUnknown = 205,
  kRivals = 206,
  kUnsent = 207,
  kClockUnheard = 208,
  kDeadChannel = 209,    ///< (channel 0..15)
  kRailedChannel = 210,  ///< its mean is where none can be (channel 0..15)
  kRecorderSays = 211,   ///< text: what
  kClockPoor = 212,      ///< a node's clock is known worse than kWantedSync_s
  kOtherVersion = 213,   ///< a node speaks another version of the wire
  kAnalyserSilent = 214,
  kNothingRecorded = 301,
  kDiskFailing = 302,
  kDiskFull = 303,
  kSamplesLost = 304,
  kNodeSilent = 305,
  kNodeFailed = 306,
  kOverload = 307,     ///< (channel 0..15)
  kClockBroken = 308,  ///< a node's clock jumped
  kFaultyTurns = 309,  ///< of an encoder, without exactly their teeth (line 0..1)
  kDeviceGone = 310,   ///< a device of a node is not there
  kWrongMarks = 311,   ///< zero marks of an encoder name no tooth, so there is no angle (line 0..1)
  kNodeMissing = 312,  ///< it does not measure though the recording goes on
  kNodeLeftOut = 313,  ///< there is no room for it
  kClipped = 314,      ///< tops are cut off at one value (channel 0..15)
};

/// Clocks of two nodes may be apart by so much: 0.3 degrees at 18 turns a second.
inline constexpr double kWantedSync_s = 50e-6;
/// In which a clock becomes known, and known well, and after which it is missed.
inline constexpr double kClockPatience_s = 10.0;

constexpr AlarmLevel level_of(AlarmCause cause) {
  return static_cast<AlarmLevel>(static_cast<std::int32_t>(cause) / 100);
}
/// A number from outside is one of them.
bool is_alarm_cause(std::int64_t number);

/// "ALARM", "WARNING", "NOTICE"
const char* word(AlarmLevel level);
/// A shape that distinguishes them without colours, three columns wide: "!!!", " ! ", " i ".
const char* shape(AlarmLevel level);
/// Three words or so: "samples lost".
const char* name_of(AlarmCause cause);

/// One thing that is wrong at one place.
struct Alarm {
  AlarmCause cause = AlarmCause::kRecorderSays;
  std::int32_t node = 0;   ///< 0: of the recorder, or of a wheel
  std::int32_t part = -1;  ///< as AlarmCause has it; -1: none

  auto operator<=>(const Alarm&) const = default;
};

/// "60 and 36 teeth lie between its zero marks, and its ring has 96: ...": why a wheel has no angle.
/// @param counts  as in the heartbeat of one line; the first is not 0
/// @param teeth   of the ring; nothing: not known here
std::string wrong_marks(std::span<const std::int32_t, 2> counts, std::optional<int> teeth = {});

/// "node 1 channel 3"; empty: of the recorder.
std::string place_of(const Alarm& alarm);
/// "ALARM node 1: samples lost"; with a text "ALARM node 1: samples lost (35 samples by now)".
std::string sentence_of(const Alarm& alarm, const std::string& text = "");

/// As one number, of a note: cause is the note's a, this its b.
std::int64_t place_number(const Alarm& alarm);
Alarm alarm_of(std::int64_t cause, std::int64_t place_number);

}  // namespace roadbalance
