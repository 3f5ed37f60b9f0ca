#pragma once

#include <string>

#include "host/recording/read_recording.hpp"

namespace roadbalance {

/// One line on standard error if the recording is not whole: a figure from damaged data never comes without
/// it.
void warn_of_defects(const std::string& command, const std::string& folder, const RecordingDefects& defects);

}  // namespace roadbalance
