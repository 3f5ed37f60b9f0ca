#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace roadbalance {

inline constexpr const char* kJobChannel = "RB_JOB";
inline constexpr const char* kDocumentChannel = "RB_DOCUMENT";
inline constexpr std::int32_t kMostJobs = 8;  ///< that are reported, one of them running
inline constexpr std::size_t kPartBytes = 1200;
inline constexpr std::int32_t kMostParts = 32;  ///< of a document

/// Request value 0 of Operation::kJob.  Named as the command of rb that does it.
enum class JobKind : std::int32_t {
  kVerify = 1,
  kIdentify = 2,
  kReport = 3,
  kExport = 4,
  kSelect = 5,
  kReduce = 6,
  kTransfer = 7,
};

enum class JobState : std::int32_t {
  kRunning = 1,
  kHeld = 2,     ///< waits: a recording is under way, whose disk it leaves alone
  kDone = 3,     ///< and all is well
  kNotWell = 4,  ///< done, and what it found is bad; text: what
  kFailed = 5,   ///< it could not be done
  kCancelled = 6,
  kInterrupted = 7,  ///< rb-recordings ended before it
};

enum class DocumentKind : std::int32_t {
  kText = 1,  ///< lines as a terminal shows them
  kPage = 2,  ///< HTML to save and print
};

/// Work on a recording; fields as in common/wire/job_t.
struct Job {
  std::int32_t place = 0, jobs = 0;
  std::int64_t job = 0;
  JobKind kind = JobKind::kVerify;
  JobState state = JobState::kRunning;
  std::string recording{}, options{};
  std::int64_t began_us = 0, ended_us = 0;
  double elapsed_s = 0;
  double progress = 0;
  std::int64_t bytes = 0, bytes_to_read = 0;
  double bytes_per_s = 0;
  DocumentKind document_kind = DocumentKind::kText;
  std::int32_t parts = 0;
  std::string transfer_to{};
  std::string text{};  ///< cut after 300 bytes
};

/// Fields as in common/wire/document_t.
struct DocumentPart {
  std::int32_t place = 0;
  std::int64_t job = 0;
  std::int32_t part = 0, parts = 0;
  std::string bytes{};  ///< at most kPartBytes
};

/// @param document  at most kMostParts * kPartBytes
std::vector<DocumentPart> parts_of(const std::string& document, std::int32_t place, std::int64_t job);

/// Decoding refuses wrong size, type and bounds.
std::vector<std::uint8_t> encode(const Job& job);
std::vector<std::uint8_t> encode(const DocumentPart& part);
std::optional<Job> decode_job(std::span<const std::uint8_t> bytes);
std::optional<DocumentPart> decode_document_part(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
