#include "common/bus/absence.hpp"

#include <algorithm>
#include <cstdio>

#include "common/clock/utc.hpp"

namespace roadbalance {

const char* words(AbsenceCause cause) {
  switch (cause) {
    case AbsenceCause::kNone:
      break;
    case AbsenceCause::kStopped:
      return "stopped by a command that was not this recorder's";
    case AbsenceCause::kSourceOver:
      return "its source has no more";
    case AbsenceCause::kDeviceFailed:
      return "its device failed: look at its cable and supply";
    case AbsenceCause::kProgramEnded:
      return "its program was ended: by its service, a person or a closed terminal";
    case AbsenceCause::kSilent:
      return "it is not heard: look at its cable and supply";
    case AbsenceCause::kNeverCame:
      return "it has not been heard: is rb-node running there, and its cable plugged in?";
  }
  return "for a reason that is not known";
}

namespace {

/// "5.2 s", "38 s", "12 min"
std::string in_words(double seconds) {
  constexpr double kWholeSeconds = 9.95, kMinutes = 599.5;
  char text[32];
  if (seconds < kMinutes)
    std::snprintf(text, sizeof text, seconds < kWholeSeconds ? "%.1f s" : "%.0f s", seconds);
  else
    std::snprintf(text, sizeof text, "%.0f min", std::min(seconds / 60.0, 1e9));
  return text;
}

}  // namespace

std::string words(const Absence& absence) {
  const std::string duration = in_words(absence.seconds);
  if (absence.from_begin && absence.to_end) return "never came";
  if (absence.from_begin) return "came " + duration + " late";
  if (absence.to_end && absence.cause == AbsenceCause::kSilent)
    return "was not heard after " + utc_text(absence.since_us, "%H:%M:%S") + " UTC, " + duration +
           " before the recording ended: look at its cable and supply";
  if (absence.to_end) return "ended " + duration + " before the recording: " + words(absence.cause);
  // It was started again: what ended it without a word was its supply or a kill.
  const char* const why =
      absence.cause == AbsenceCause::kSilent ? "its supply or its program failed" : words(absence.cause);
  return "was away for " + duration + ": " + why;
}

std::string node_words(std::int32_t node, const std::string& name) {
  return "node " + std::to_string(node) + (name.empty() ? "" : " (" + name + ")");
}

}  // namespace roadbalance
