#pragma once

#include <nlohmann/json.hpp>

#include "host/orders/orders_of_record.hpp"

namespace roadbalance {

/// What was found of one rotor in the channels of one node.
/// @param waterfall  a spectrum for each class of speed, too
nlohmann::ordered_json rotor_json(const RecordOrders& found, const RotorOrders& rotor, bool waterfall);

/// Why no phase is claimed of a rotor, or what the angle it is of was made of; empty: there is nothing to
/// say.
std::string remark_on(const RecordOrders& found, const RotorOrders& rotor);

}  // namespace roadbalance
