#pragma once

#include <filesystem>

#include "common/bus/recording.hpp"
#include "host/recorder/verify.hpp"

namespace roadbalance {

/// What a finished recording proves: verdict, samples, losses, repairs, overload, clocks and marks.  Reads it
/// twice; never throws for what is in the folder.
RecordingReceipt receipt_of(const std::filesystem::path& folder);

/// The same of a recording that verify_record() has read: reads it once more.
RecordingReceipt receipt_of(const std::filesystem::path& folder, const Verification& proof);

/// The folder's name and size alone.
RecordingReceipt unread(const std::filesystem::path& folder);

}  // namespace roadbalance
