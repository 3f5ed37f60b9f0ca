#pragma once

#include <filesystem>

#include "common/bus/recording.hpp"

namespace roadbalance {

/// What a finished recording proves: verdict, samples, losses, repairs, overload, clocks and marks.  Reads it
/// twice; never throws for what is in the folder.
RecordingReceipt receipt_of(const std::filesystem::path& folder);

/// The folder's name and size alone.
RecordingReceipt unread(const std::filesystem::path& folder);

}  // namespace roadbalance
