#pragma once

#include <stop_token>

#include "host/excerpt/excerpt_request.hpp"
#include "host/excerpt/pieces.hpp"
#include "host/exchange/survey.hpp"

namespace roadbalance {

/// The stretches of a recording that are wanted; reads its samples if speed or quality are asked for.
/// @param table  of this survey
/// @throws ConfigError naming the option if nothing is left, or a mark is not there
Pieces find_pieces(const ExcerptRequest& request, const RecordingSurvey& survey, const ExportTable& table,
                   const std::stop_token& stop);

}  // namespace roadbalance
