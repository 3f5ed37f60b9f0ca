#pragma once

#include <stop_token>

#include "host/excerpt/excerpt_request.hpp"
#include "host/excerpt/pieces.hpp"
#include "host/exchange/survey.hpp"

namespace roadbalance {

/// What the samples of a recording say of its time.
struct JudgedTime {
  Pieces at_speed;  ///< the car's speed is within the limits
  Pieces covered;   ///< all chosen nodes have begun and not ended
  Pieces unclean;   ///< of a chosen node samples are missing, a chosen channel left its range or an angle is
                    ///< not known
};

/// Reads the recording once.
/// @throws as read_recording(); std::runtime_error if `stop` was requested; ConfigError if a speed is asked
/// for and no node reads a wheel
JudgedTime judge_time(const ExcerptRequest& request, const RecordingSurvey& survey,
                      const std::stop_token& stop);

}  // namespace roadbalance
