#pragma once

#include <filesystem>

#include "common/bus/recording.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {

/// The summary of a finished recording: verdict, samples, losses, repairs, overload, clocks and marks.  Reads
/// it twice; content of the folder never makes it throw.
RecordingSummary summary_of(const std::filesystem::path& folder);

/// The same for a recording that verify_record() has read: reads it once more.
RecordingSummary summary_of(const std::filesystem::path& folder, const Verification& proof);

/// A summary with the folder's name and size only.
RecordingSummary unread(const std::filesystem::path& folder);

}  // namespace roadbalance
