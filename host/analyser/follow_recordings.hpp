#pragma once

#include <filesystem>
#include <stop_token>

#include "host/analyser/analyser.hpp"

namespace roadbalance {

/// Process: run_analyser on each recording in turn that the recorder makes, from when it reports its name
/// until it reports another; in between the last one stays.
///
/// Before the first one options.vehicle describes the channels, if it is given: there are levels, and taps
/// are heard, before anything is recorded.  Among it and the files beside it, the one by which the nodes
/// measure is in force: whatever is chosen or changed between recordings counts at once.
///
/// With options.exit_at_end it returns once the last recording has ended, its last estimate is out, and no
/// node is left that could be recorded again.
/// @param recordings  folder of recordings, each a folder of its name; options.record is not used
/// @throws as run_analyser
void follow_recordings(std::stop_token stop, const std::filesystem::path& recordings,
                       const AnalyserOptions& options);

}  // namespace roadbalance
