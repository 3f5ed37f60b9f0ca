#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/bus/recording.hpp"

namespace roadbalance {

/// The recordings right in a folder as the page lists them: newest first, with what each proves, unless one
/// of them is being written.  Reads all of them.
std::vector<RecordingReceipt> recordings_in(const std::filesystem::path& folder);

nlohmann::ordered_json recordings_json(const std::vector<RecordingReceipt>& recordings);
void print_recordings(const std::vector<RecordingReceipt>& recordings);

}  // namespace roadbalance
