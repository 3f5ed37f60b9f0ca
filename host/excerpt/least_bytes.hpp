#pragma once

#include <cstdint>

#include "host/excerpt/excerpt_request.hpp"
#include "host/excerpt/pieces.hpp"
#include "host/exchange/survey.hpp"

namespace roadbalance {

/// What an excerpt takes on its disk at least: the scans of the chosen nodes in these pieces, in full blocks.
/// All that is missing in the recording is taken to be missing there; edges, signals and the journal come on
/// top.  So it refuses nothing that would fit.
std::uint64_t least_excerpt_bytes(const ExcerptRequest& request, const RecordingSurvey& survey,
                                  const Pieces& pieces);

}  // namespace roadbalance
