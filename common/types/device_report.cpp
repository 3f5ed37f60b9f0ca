#include "common/types/device_report.hpp"

namespace roadbalance {
namespace {

struct Words {
  const char* name;
  const char* sentence;
};

constexpr std::array<Words, kDeviceCounters> kWords{{
    {"gone", "was unplugged or went down"},
    {"returned", "is there again"},
    {"bus_off", "bus-off: the controller no longer takes part in the bus"},
    {"error_passive", "error-passive: the controller sees many errors on the bus"},
    {"bus_errors", "the controller saw errors on the bus"},
    {"queue_overflow", "frames were lost because the kernel had no room for them"},
    {"frames_refused", "frames were refused: wrong length, or a value out of its range"},
    {"stalls", "the board halted its transfers"},
    {"short_packets", "packets ended before their time"},
    {"packets_refused", "packets were refused: wrong mark, length or CRC"},
    {"packets_missing", "packets are missing"},
    {"board_overrun", "the board lost scans before it could send them"},
    {"edges_lost", "encoder edges are missing"},
    {"late_edges", "encoder edges came after their scans and were not used"},
    {"readers_too_slow", "the node did not fetch in time what the device had"},
    {"controller_overrun", "the controller lost frames because nobody fetched them from it"},
    {"glitches", "the board dropped conversions that came too soon: is its SYNC noisy?"},
    {"out_of_step", "was out of step with the first board; both were started again"},
    {"partner_late", "scans of the other board were dropped because this one's did not come"},
    {"clock_unanswered", "the board did not say what its clock shows: stamps are worse"},
    {"faulty_turns", "turns came without exactly their teeth; they are flagged"},
    {"count_broken", "the count of teeth on the bus broke; no angle until zero marks place it again"},
    {"marks_elsewhere", "zero marks lay elsewhere among the bus's teeth than those before; flagged"},
}};

}  // namespace

const char* sentence(DeviceCounter counter) {
  return kWords[static_cast<std::size_t>(counter)].sentence;
}

std::string sentence(DeviceCounter counter, std::int64_t times) {
  return std::string(sentence(counter)) + " (" + std::to_string(times) + (times == 1 ? " time" : " times") +
         " by now)";
}

const char* name_of(DeviceCounter counter) {
  return kWords[static_cast<std::size_t>(counter)].name;
}

}  // namespace roadbalance
