#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace roadbalance {

/// Requests of a person to the measuring system, and their answers; fields as in common/wire.  One form for
/// page and command line.  The recorder answers: it owns the nodes, which obey nobody else; of finished
/// recordings rb-recordings does (is_of_recordings()).

/// request_t.operation; in brackets what the other fields are.
enum class Operation : std::int32_t {
  kStart = 1,  ///< begins a recording (text: its name; empty: by date and time; nodes); done's value 0 is how
               ///< many of its nodes are not there
  kStop = 2,   ///< ends it; done when all is on the disk, with a receipt
  kMark = 3,   ///< puts an event into the recording (text)
  kRange = 4,  ///< of a channel (node, channel; value 0: m/s²)
  kFilter = 5,   ///< anti-aliasing of all nodes (value 0: corner, Hz; value 1: order)
  kZero = 6,     ///< the mean of the last seconds is the reading at rest (node; 0: every one)
  kVehicle = 7,  ///< chooses the vehicle file (text: its name in the recorder's folder, no path)
  kJob = 8,      ///< does something with a finished recording (value 0: JobKind; text: RECORDING or
                 ///< RECORDING/KEY=VALUE/..., as in host/recordings/job_order.hpp; no name has a slash)
  kCancel = 9,   ///< ends a job before it is done (value 0: its number)
  kScale = 10,   ///< a channel's scale by gravity, both ways up (node, channel; value 0: 1 if the positive
                 ///< direction points up now, -1 if down); the second of the two sets it
  kReading =
      11,       ///< of a wheel that is turned by hand, while a recording is under way (channel: the wheel, 0
                ///< front_left ..; value 0: where its reference point stands, rad from the upward vertical
                ///< in the direction of forward rotation; value 1: 1, or 0 to begin with this wheel); done's
                ///< values are the datum so far and its standard deviation, rad, 0 while there is none
  kDatum = 12,  ///< where a wheel's zero mark fires (channel: the wheel; value 0: rad, value 1: its standard
                ///< deviation, above 0)
};

/// Asked of rb-recordings; the others of rb-recorder.
constexpr bool is_of_recordings(Operation operation) {
  return operation == Operation::kJob || operation == Operation::kCancel;
}

/// answer_t.state.
enum class AnswerState : std::int32_t { kUnderWay = 1, kDone = 2, kRefused = 3 };

/// answer_t.reason.
enum class RefusalReason : std::int32_t {
  kNone = 0,
  kUnknownOperation = 1,
  kBadArgument = 2,   ///< a name, number, node or channel that cannot be; text: which
  kRecording = 3,     ///< not while a recording is under way
  kNotRecording = 4,  ///< only while one is
  kNameTaken = 5,     ///< there is a recording of this name
  kNoNode = 6,        ///< the node is not on the bus, or none is
  kDisk = 7,          ///< the disk refuses
  kMoving = 8,        ///< the car must stand still
  kNotSupported = 9,  ///< the node's device does not have it; text: what it has
  kNoAnswer = 10,     ///< a node did not answer
  kNotOperable = 11,  ///< this recorder records what its command line asks for, until it is stopped there
  kBusy = 12,         ///< one thing at a time; text: which is under way
};

struct Request {
  std::int64_t asker = 0;
  std::int64_t request = 0;
  Operation operation = Operation::kMark;
  std::int32_t node = 0;
  std::int32_t channel = -1;
  std::array<double, 2> value{};
  std::string text{};   ///< at most kMostRequestText bytes
  std::string nodes{};  ///< of a start: names or numbers, ", " between; empty: every node
  std::string who{};    ///< cut after kMostWhoBytes

  bool operator==(const Request&) const = default;
};
inline constexpr std::size_t kMostRequestText = 400, kMostNodesText = 200;
/// The limit of askers' and requests' numbers: a browser's numbers are exact so far.
inline constexpr std::int64_t kRequestLimit = std::int64_t{1} << 53;

struct Answer {
  std::int64_t asker = 0;
  std::int64_t request = 0;
  std::int64_t time_us = 0;
  Operation operation = Operation::kMark;
  AnswerState state = AnswerState::kUnderWay;
  RefusalReason reason = RefusalReason::kNone;
  std::int32_t node = 0;
  std::int32_t channel = -1;
  std::array<double, 2> value{};
  std::string text{};  ///< cut after kMostRequestText bytes
};

/// Under way: takes the request's numbers along, so that who asked recognises it.
Answer answer_to(const Request& request, std::int64_t utc_us);

/// receipt_t: of one node in a finished recording.
struct Receipt {
  std::int64_t incarnation = 0;
  std::int64_t began_us = 0;
  std::int64_t ended_us = 0;
  std::int32_t index = 0;
  std::int32_t nodes = 0;
  std::int32_t node = 0;
  std::int32_t epochs = 0;
  std::int32_t open_epochs = 0;
  std::int64_t samples_sent = 0;
  std::int64_t samples_recorded = 0;
  std::int64_t gaps = 0;
  std::int64_t repaired = 0;
  double overload_s = 0;
  double sync_us = -1;
  std::uint32_t blocks_crc32c = 0;
  std::optional<bool> sums_agree{};  ///< nothing: not known, as where blocks were lost
  std::int64_t bytes = 0;
  std::int32_t marks = 0;
  std::string name{};        ///< at most kMostNameBytes
  std::string absence{};     ///< cut after kMostAbsenceBytes
  std::string unheard{};     ///< cut after kMostWhoBytes
  std::string stopped_by{};  ///< cut after kMostWhoBytes

  /// When its node did not measure or was not heard, and why; empty: it measured from start to stop.
  std::string missing() const { return absence + (absence.empty() || unheard.empty() ? "" : "; ") + unheard; }
};
inline constexpr std::size_t kMostAbsenceBytes = 200, kMostWhoBytes = 100;
inline constexpr std::size_t kMostNameBytes = 64;

inline constexpr const char* kRequestChannel = "RB_REQUEST";
inline constexpr const char* kAnswerChannel = "RB_ANSWER";
inline constexpr const char* kReceiptChannel = "RB_RECEIPT";

/// Decoding refuses wrong size, type, CRC or bounds, and text that is no UTF-8 or has control characters.  An
/// operation of a newer page passes, so that it is answered kUnknownOperation.
std::vector<std::uint8_t> encode(const Request& request);
std::vector<std::uint8_t> encode(const Answer& answer);
std::vector<std::uint8_t> encode(const Receipt& receipt);
std::optional<Request> decode_request(std::span<const std::uint8_t> bytes);
std::optional<Answer> decode_answer(std::span<const std::uint8_t> bytes);
std::optional<Receipt> decode_receipt(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
