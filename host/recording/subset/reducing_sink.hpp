#pragma once

#include <memory>

#include "host/recording/subset/epoch_sink.hpp"

namespace roadbalance {

/// Passes every factor-th scan, behind reduction_taps(), to another sink; edges and signals as they are.
///
/// The new scans lie on one grid from the first one on, whatever is missing between.  The filter never spans
/// a gap: each gap grows by the filter's reach on both sides and keeps its cause, and as much is left out at
/// the begin and at the end.
std::unique_ptr<EpochSink> make_reducing_sink(int factor, std::unique_ptr<EpochSink> to);

}  // namespace roadbalance
