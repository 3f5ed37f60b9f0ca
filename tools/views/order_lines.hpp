#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/order_report.hpp"

namespace roadbalance {

using OrderReports = std::map<std::pair<std::int32_t, std::int32_t>, OrderReport>;  ///< by wheel and node

/// For people: the wheel's first and second order in the channel of all nodes that shows most of it.
std::vector<std::string> strongest_order_lines(const OrderReports& reports, std::int32_t wheel);

/// The same of all channels of a report of which anything is known.
std::vector<std::string> order_lines(const OrderReport& report);

/// For programs; what is not known is null.
nlohmann::ordered_json order_report_json(const OrderReport& report);

}  // namespace roadbalance
