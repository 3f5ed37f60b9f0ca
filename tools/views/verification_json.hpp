#pragma once

#include <nlohmann/json.hpp>

#include "host/recording/verify/verify.hpp"

namespace roadbalance {

/// rb verify's and rb recover's result for a record: for programs, and for people on standard output.
nlohmann::ordered_json verification_json(const Verification& result);
void print_verification(const Verification& result);

}  // namespace roadbalance
