#pragma once

#include <nlohmann/json.hpp>

#include "host/analysis/orders/orders_of_record.hpp"

namespace roadbalance {

/// Results for one rotor in the channels of one node.
/// @param waterfall  a spectrum for each class of speed, too
nlohmann::ordered_json rotor_json(const RecordOrders& found, const RotorOrders& rotor, bool waterfall);

/// Why no phase is given for a rotor, or the origin of its angle; empty: there is nothing to report.
std::string remark_on(const RecordOrders& found, const RotorOrders& rotor);

}  // namespace roadbalance
