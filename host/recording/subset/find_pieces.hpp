#pragma once

#include <stop_token>

#include "host/recording/formats/export_table.hpp"
#include "host/recording/formats/survey.hpp"
#include "host/recording/subset/pieces.hpp"
#include "host/recording/subset/subset_request.hpp"

namespace roadbalance {

/// The wanted stretches of a recording; reads its samples if speed or quality matter.
/// @param table  of this survey
/// @throws ConfigError naming the option if nothing is left, or a mark does not exist
Pieces find_pieces(const SubsetRequest& request, const RecordingSurvey& survey, const ExportTable& table,
                   const std::stop_token& stop);

}  // namespace roadbalance
