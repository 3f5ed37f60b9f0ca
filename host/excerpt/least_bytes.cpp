#include "host/excerpt/least_bytes.hpp"

#include <algorithm>

#include "common/bus/scan_format.hpp"
#include "host/excerpt/channel_choice.hpp"

namespace roadbalance {
namespace {

/// Of a piece, at its ends: parts of blocks, and rounding of times.
constexpr double kUnsure = 2.0 * kScansPerBlock;
/// New samples that the filter of rb reduce leaves out at the ends of a stretch.
constexpr double kFiltered = 2.0 * 35.0;

double scans_in(const RecordedSpan& span, const Piece& piece) {
  const double from_ns = static_cast<double>(std::max(span.first_host_ns(), piece.from_ns));
  const double to_ns = static_cast<double>(std::min(span.end_ns(), piece.to_ns));
  return std::max(0.0, 1000.0 * (to_ns - from_ns) / static_cast<double>(span.period_ps) - kUnsure);
}

}  // namespace

std::uint64_t least_excerpt_bytes(const ExcerptRequest& request, const RecordingSurvey& survey,
                                  const Pieces& pieces) {
  double blocks = 0.0;
  for (const RecordedSpan& span : survey.span) {
    const NodeConfig* node = survey.vehicle.node_with_id(span.node);
    const bool is_timed = span.first_fit || !survey.own_clocks();
    if (node == nullptr || !is_timed || chosen_channels(request.choice, *node) == 0) continue;
    const std::int64_t missing = span.next_scan - span.first_scan - span.samples;
    double scans = -static_cast<double>(missing);
    for (const Piece& piece : pieces) {
      const double here = scans_in(span, piece);
      scans += request.factor > 1 ? std::max(0.0, here / request.factor - kFiltered) : here;
    }
    // How many gaps there are, by each of which the filter leaves out more, is not known.
    if (request.factor > 1 && missing > 0) scans = 0.0;
    blocks += std::max(0.0, scans) / kScansPerBlock;
  }
  return static_cast<std::uint64_t>(blocks * static_cast<double>(wire_format::kScanBytes));
}

}  // namespace roadbalance
